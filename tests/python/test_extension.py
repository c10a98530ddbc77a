"""The add-on's zips: what builds them. tests/blender installs them."""

import os
import re
import time
import zipfile
from pathlib import Path

import ifa
import pytest

from scripts.extension import __main__ as extension
from scripts.extension import archives, licences

ROOT = Path(__file__).resolve().parents[2]


def fill(folder: Path, names: list[str], mtime: float) -> Path:
    for name in names:
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(f"text of {name}\n" * 100)
        os.utime(path, (mtime, mtime))
    return folder


def test_a_zip_depends_on_its_contents_alone(tmp_path: Path) -> None:
    names = ["b.py", "a/z.txt", "a/b/c.txt", "wheels/d.whl"]
    first = fill(tmp_path / "first", names, time.time())
    second = fill(tmp_path / "second", names[::-1], time.time() - 1e7)
    (second / "b.py").chmod(0o600)
    one = archives.write_zip(first, tmp_path / "one.zip")
    two = archives.write_zip(second, tmp_path / "two.zip")
    assert one.read_bytes() == two.read_bytes()
    with zipfile.ZipFile(one) as archive:
        assert archive.namelist() == sorted(names)
        assert archive.read("a/b/c.txt") == b"text of a/b/c.txt\n" * 100
    (second / "b.py").write_text("another")
    assert archives.write_zip(second, two).read_bytes() != one.read_bytes()


def test_the_addon_gets_the_version_of_the_project(tmp_path: Path) -> None:
    assert extension.version() == ifa.__version__
    extension.copy_addon(tmp_path / "addon")
    text = (tmp_path / "addon" / "__init__.py").read_text()
    numbers = ", ".join(ifa.__version__.split("."))
    assert f'"version": ({numbers}),\n' in text
    assert "GNU GENERAL PUBLIC LICENSE" in (tmp_path / "addon" / "LICENSE").read_text()
    assert not list(tmp_path.rglob("__pycache__"))


def test_the_addon_and_the_builder_agree_on_the_folder_of_the_core() -> None:
    core = (ROOT / "addon" / "ifa_addon" / "core.py").read_text()
    assert re.search(r'BUNDLED = .*"(\w+)"', core).group(1) == extension.UNPACKED


def test_licences_that_are_only_referred_to_come_along(tmp_path: Path) -> None:
    common = licences.COMMON
    if not (common / "LGPL-2.1").is_file():
        pytest.skip(f"{common} is Debian's")
    (tmp_path / "libx.txt").write_text(
        f"... can be found in '{common}/LGPL-2.1'. Or {common}/GPL-3."
    )
    licences.copy_common(tmp_path)
    assert sorted(p.name for p in tmp_path.iterdir()) == ["GPL-3.txt", "LGPL-2.1.txt", "libx.txt"]
    assert (tmp_path / "LGPL-2.1.txt").read_bytes() == (common / "LGPL-2.1").read_bytes()
