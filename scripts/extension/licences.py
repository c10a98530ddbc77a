"""Collects the licence texts of what the zips contain, from where each was installed."""

from __future__ import annotations

import re
import shutil
import subprocess
from importlib import metadata
from pathlib import Path

from scripts.extension.wheels import REPOSITORY, BuildError, Wheel

HEADERS = ("libeigen3-dev", "libnanoflann-dev")  # compiled into the module
COMMON = Path("/usr/share/common-licenses")


def collect(wheels: list[Wheel], folder: Path) -> None:
    """One file for each component, the common licences they refer to, and where the source is."""
    folder.mkdir()
    shutil.copy(REPOSITORY / "LICENSE", folder / "ifa.txt")
    shutil.copy(pybind11_licence(), folder / "pybind11.txt")
    libraries = {library for wheel in wheels for library in wheel.needed}
    packages = sorted({*HEADERS, *map(package_of, libraries)})
    for package in packages:
        text = Path("/usr/share/doc") / package / "copyright"
        if not text.is_file():
            raise BuildError(f"{text} is missing: the zips must not go out without it")
        shutil.copy(text, folder / f"{package}.txt")
    copy_common(folder)
    (folder / "SOURCES.txt").write_text(sources(packages))


def package_of(library: Path) -> str:
    """The Debian package that installed a library."""
    # dpkg may know it by its path from before /lib became a link to /usr/lib.
    for path in (library, Path(str(library).removeprefix("/usr"))):
        done = subprocess.run(["dpkg-query", "-S", path], capture_output=True, text=True)
        if done.returncode == 0:
            return done.stdout.split(":")[0]
    raise BuildError(f"{library} belongs to no Debian package: its licence is not known")


def sources(packages: list[str]) -> str:
    """Which source made each library: the LGPL lets everyone have it, change it and put it back."""
    form = "${Package}: Debian source package ${source:Package} ${source:Version}\n"
    command = ["dpkg-query", "-W", "-f", form, *packages]
    listed = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    return (
        "The core links these libraries, as Debian distributes them; those that are shared lie in\n"
        "ifa.libs beside it and may be replaced.\n\n" + listed
    )


def pybind11_licence() -> Path:
    for file in metadata.files("pybind11") or []:
        if file.name == "LICENSE":
            return Path(str(file.locate()))
    raise BuildError("The installed pybind11 has no licence text")


def copy_common(folder: Path) -> None:
    """The texts that Debian's copyright files only refer to."""
    named = set()
    for path in folder.iterdir():
        text = path.read_text(errors="replace")
        named |= set(re.findall(rf"{COMMON}/([A-Za-z]+(?:-[0-9.]*[0-9])?)", text))
    for name in sorted(named):
        source = COMMON / name
        if not source.is_file():
            raise BuildError(f"{source} is missing: the zips must not go out without it")
        shutil.copy(source, folder / f"{name}.txt")
