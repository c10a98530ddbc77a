"""Zips whose bytes depend on their contents alone, and folders to fill them from."""

from __future__ import annotations

import shutil
import zipfile
from pathlib import Path

EARLIEST_TIME = (1980, 1, 1, 0, 0, 0)  # the first that a zip can hold
PLAIN_FILE_MODE = 0o644 << 16


def write_zip(folder: Path, path: Path) -> Path:
    """Every file below `folder`, in order of name, without its time or owner."""
    files = sorted(entry for entry in folder.rglob("*") if entry.is_file())
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED, compresslevel=9) as archive:
        for file in files:
            entry = zipfile.ZipInfo(file.relative_to(folder).as_posix(), EARLIEST_TIME)
            # A wheel is a zip already.
            packed = file.suffix == ".whl"
            entry.compress_type = zipfile.ZIP_STORED if packed else zipfile.ZIP_DEFLATED
            entry.external_attr = PLAIN_FILE_MODE
            archive.writestr(entry, file.read_bytes(), compresslevel=9)
    return path


def empty_folder(path: Path) -> Path:
    shutil.rmtree(path, ignore_errors=True)
    path.mkdir(parents=True)
    return path


def copy_package(source: Path, target: Path) -> None:
    shutil.copytree(source, target, ignore=shutil.ignore_patterns("__pycache__"))
