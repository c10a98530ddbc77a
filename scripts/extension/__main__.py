"""Builds both zips into build/extension: python -m scripts.extension [--out FOLDER]."""

from __future__ import annotations

import argparse
import re
import shutil
import sys
import zipfile
from pathlib import Path

from scripts.extension import archives, licences, wheels
from scripts.extension.wheels import REPOSITORY, BuildError, Wheel

ADDON = REPOSITORY / "addon"
EXTENSION_ID = "inverse_foley_animation"
LEGACY_TAG = "cp311"  # Debian's Blender 3.4 and Blender 4.1
UNPACKED = "wheels_unpacked"  # where core.py looks for the core in an add-on without wheels

# What a manifest may hold: docs.blender.org, Blender Manual, Extensions, Add-ons.
MANIFEST = """\
schema_version = "1.0.0"

id = "{id}"
version = "{version}"
name = "Inverse-Foley Animation"
tagline = "Rigid-body motion whose contacts land on the marks of a sound"
maintainer = "The IFA authors"
type = "add-on"
tags = ["Animation", "Physics", "Sequencer"]
blender_version_min = "4.2.0"
license = ["SPDX:GPL-3.0-or-later"]
platforms = ["linux-x64"]
wheels = [
{wheels}
]

[permissions]
files = "Read the sounds and lists of marks that you choose"
"""


def version() -> str:
    """The one in CMakeLists.txt."""
    text = (REPOSITORY / "CMakeLists.txt").read_text()
    return re.search(r"project\(ifa VERSION ([0-9]+\.[0-9]+\.[0-9]+)", text).group(1)


def copy_addon(target: Path) -> None:
    """The add-on, its `bl_info` with the version, and its licence."""
    archives.copy_package(ADDON / "ifa_addon", target)
    shutil.copy(ADDON / "LICENSE", target / "LICENSE")
    init = target / "__init__.py"
    numbers = ", ".join(version().split("."))
    text, count = re.subn(
        r'"version": \(0, 0, 0\),.*', f'"version": ({numbers}),', init.read_text()
    )
    if count != 1:
        raise BuildError(
            f"{ADDON / 'ifa_addon' / '__init__.py'} has no version (0, 0, 0) to replace"
        )
    init.write_text(text)


def extension_zip(made: list[Wheel], out: Path) -> Path:
    """For Blender 4.2 and later: a manifest, and the wheels as they are."""
    folder = archives.empty_folder(out / "extension")
    copy_addon(folder / EXTENSION_ID)
    root = folder / EXTENSION_ID
    licences.collect(made, root / "licences")
    (root / "wheels").mkdir()
    for wheel in made:
        shutil.copy(wheel.path, root / "wheels")
    names = ",\n".join(f'  "./wheels/{wheel.path.name}"' for wheel in made)
    manifest = MANIFEST.format(id=EXTENSION_ID, version=version(), wheels=names)
    (root / "blender_manifest.toml").write_text(manifest)
    return archives.write_zip(root, out / f"{EXTENSION_ID}-{version()}-linux_x64.zip")


def legacy_zip(wheel: Wheel, out: Path) -> Path:
    """For Blender before 4.2: an add-on folder with the core unpacked inside."""
    folder = archives.empty_folder(out / "legacy")
    copy_addon(folder / "ifa_addon")
    licences.collect([wheel], folder / "ifa_addon" / "licences")
    with zipfile.ZipFile(wheel.path) as archive:
        archive.extractall(folder / "ifa_addon" / UNPACKED)
    return archives.write_zip(folder, out / f"ifa_addon-{version()}-legacy-linux_x64.zip")


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=REPOSITORY / "build" / "extension")
    out = parser.parse_args().out.resolve()
    staging = archives.empty_folder(out / "staging")
    for old in out.glob("*.zip"):
        old.unlink()
    try:
        made = []
        for tag in wheels.PYTHONS:
            wheel = wheels.build(tag, staging)
            if wheel is None:
                print(f"extension: no Python for {tag} here: the zips go without that wheel")
            else:
                made.append(wheel)
        if not made:
            raise BuildError("there is no Python to build the core for")
        paths = [extension_zip(made, staging)]
        paths += [legacy_zip(wheel, staging) for wheel in made if wheel.tag == LEGACY_TAG]
    except BuildError as error:
        print(f"extension: {error}", file=sys.stderr)
        return 1
    for path in paths:
        final = path.replace(out / path.name)
        print(f"extension: {final} ({final.stat().st_size / 1e6:.1f} MB)")
    return 0


if __name__ == "__main__":
    sys.exit(main())
