/* What runs under qemu: loads shared objects, tells addresses in them, calls them. Its memory is the host's, at the same
   address, so that pointers mean the same in both. Requests are lines on stdin, answers lines on stdout. */
#include <dlfcn.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/mman.h>

typedef void (*kernel)(int64_t, int64_t, int64_t, int64_t, int64_t, int64_t);

int main(int count, char **given) { /* the descriptor, address and size of the memory */
    void *wanted = (void *)strtoull(given[2], NULL, 10);
    void *memory = mmap(wanted, strtoull(given[3], NULL, 10), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_FIXED_NOREPLACE,
                        atoi(given[1]), 0);
    if (count != 4 || memory != wanted)
        return 2;
    void *library = NULL;
    char kind, text[4096];
    int64_t address, a[6];
    while (scanf(" %c", &kind) == 1) {
        if (kind == 'l' && scanf("%4095s", text) == 1) {
            library = dlopen(text, RTLD_NOW | RTLD_LOCAL);
            puts(library ? "loaded" : dlerror());
        } else if (kind == 'a' && scanf("%4095s", text) == 1) {
            printf("%lld\n", (long long)(intptr_t)dlsym(library, text));
        } else if (kind == 'c' && scanf("%lld %lld %lld %lld %lld %lld %lld", (long long *)&address, (long long *)&a[0],
                                        (long long *)&a[1], (long long *)&a[2], (long long *)&a[3], (long long *)&a[4],
                                        (long long *)&a[5]) == 7) {
            ((kernel)address)(a[0], a[1], a[2], a[3], a[4], a[5]);
            puts("done");
        } else
            return 3;
        fflush(stdout);
    }
    return 0;
}
