"""Many runs at once: the same bits however they are dealt out, and every way in which a run may end."""
