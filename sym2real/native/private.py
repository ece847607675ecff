"""A folder that nobody but its user can write to: a library that is loaded from it runs with the user's rights.

What opens a library looks it up by its path, so those who may write to a folder above could put another one in its
place: they must not be able to either (as of the keys of ssh).
"""

import errno
import os
import shutil
import stat
from contextlib import suppress
from pathlib import Path

POSIX = os.name == "posix"  # elsewhere, the folders of a profile are their user's by inheritance
ALONE, OTHERS_WRITE = 0o700, 0o022


def private_folder(folder: Path) -> Path:
    """The folder behind all links, made where it is missing, of mode 0700 whatever the umask.

    Where others could write to it before, what they could have left is removed.

    Raises:
        OSError: where it belongs to somebody else, others may write to a folder above it, or it cannot be made.
    """
    missing = [place for place in (folder, *folder.parents) if not place.exists()]
    for place in reversed(missing):
        place.mkdir(mode=ALONE, exist_ok=True)
    if not POSIX:
        return folder
    folder = folder.resolve()
    about = folder.stat()
    if not stat.S_ISDIR(about.st_mode):
        raise NotADirectoryError(errno.ENOTDIR, "it is no folder", str(folder))
    if about.st_uid != os.geteuid():
        raise PermissionError(errno.EPERM, f"it belongs to user {about.st_uid}", str(folder))
    for above in folder.parents:
        if _others_write(above.stat()):
            raise PermissionError(errno.EPERM, f"others may write to {above}", str(folder))
    if stat.S_IMODE(about.st_mode) != ALONE:
        folder.chmod(ALONE)
    if about.st_mode & OTHERS_WRITE:
        _remove_foreign(folder)
    return folder


def is_own(file: Path) -> bool:
    """Whether it is a plain file of this user's that nobody else may write to."""
    about = file.lstat()
    if not POSIX:
        return stat.S_ISREG(about.st_mode)
    return stat.S_ISREG(about.st_mode) and about.st_uid == os.geteuid() and not about.st_mode & OTHERS_WRITE


def _others_write(about: os.stat_result) -> bool:
    """Whether others may exchange what lies in a folder; a user's private group has the user's number."""
    group = about.st_mode & stat.S_IWGRP and about.st_gid != os.geteuid()
    return bool(group or about.st_mode & stat.S_IWOTH) and not about.st_mode & stat.S_ISVTX


def _remove_foreign(folder: Path) -> None:
    for path in folder.iterdir():
        with suppress(FileNotFoundError):  # another process of this user's was faster
            if path.is_dir() and not path.is_symlink():
                shutil.rmtree(path)
            elif not is_own(path):
                path.unlink()
