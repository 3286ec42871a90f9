"""What Numba has kept of older sources is compiled anew."""

import os

from lienumba.reference import compiling


def test_an_index_older_than_any_source_is_forgotten(tmp_path):
    old, new, other = (tmp_path / name for name in ("step.march-1.nbi", "step.project-2.nbi", "step.march-1.1.nbc"))
    for file in (old, new, other):
        file.write_text("")
    os.utime(old, (1, 1))
    os.utime(other, (1, 1))
    compiling._forget_stale(tmp_path)
    assert not old.exists()
    assert new.exists()
    assert other.exists()
