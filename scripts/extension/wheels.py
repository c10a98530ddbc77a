"""Builds the core's wheel for each Python and puts the libraries it needs inside."""

from __future__ import annotations

import os
import re
import subprocess
import sys
import zipfile
from dataclasses import dataclass
from pathlib import Path

from scripts.extension.archives import empty_folder

REPOSITORY = Path(__file__).resolve().parents[2]
# Blender 4.2 to 5.0 run Python 3.11, Blender 5.1 and later 3.13.
PYTHONS = {"cp311": ".venv", "cp313": "build/cp313"}


class BuildError(Exception):
    """The zips cannot be built; one sentence that says why."""


@dataclass(frozen=True)
class Wheel:
    path: Path  # repaired
    tag: str  # cp311
    needed: tuple[Path, ...]  # the libraries of this machine that were put inside


def run(*command: str | Path, **environment: str) -> str:
    """The command's output; where it fails, all it said goes to the terminal."""
    done = subprocess.run(
        [str(part) for part in command],
        cwd=REPOSITORY,
        env={**os.environ, **environment},
        capture_output=True,
        text=True,
    )
    if done.returncode:
        sys.stderr.write(done.stdout + done.stderr)
        raise BuildError(f"{Path(command[0]).name} failed with exit code {done.returncode}")
    return done.stdout


def build(tag: str, out: Path) -> Wheel | None:
    """A wheel that runs wherever glibc is as new as here; None without that Python."""
    python = REPOSITORY / PYTHONS[tag] / "bin" / "python"
    version = "import sys; print('cp{}{}'.format(*sys.version_info))"
    if not python.exists() or run(python, "-c", version).strip() != tag:
        return None
    plain = empty_folder(out / "plain" / tag)
    # What `make build` compiled and the tests ran: only the bindings are compiled for each Python.
    prebuilt = REPOSITORY / "build" / "cmake"
    cache = (prebuilt / "CMakeCache.txt").read_text()
    compiler = re.search(r"^CMAKE_CXX_COMPILER:\w+=(.+)$", cache, re.MULTILINE).group(1)
    run(
        *(python, "-m", "pip", "--disable-pip-version-check", "wheel", "--quiet", "--no-deps"),
        *("--no-build-isolation", "--wheel-dir", plain, "."),
        *("--config-settings", f"build-dir=build/wheel_{tag}"),
        *("--config-settings", f"cmake.define.IFA_PREBUILT={prebuilt}"),
        *("--config-settings", "cmake.define.IFA_WARNINGS_AS_ERRORS=ON"),
        SOURCE_DATE_EPOCH="315532800",
        CXX=compiler,
    )
    (wheel,) = plain.glob("*.whl")
    return repair(tag, wheel, out)


def repair(tag: str, wheel: Path, out: Path) -> Wheel:
    auditwheel = Path(sys.executable).with_name("auditwheel")
    repaired = empty_folder(out / tag)
    path = os.pathsep.join([str(auditwheel.parent), os.environ.get("PATH", "")])
    command = (auditwheel, "repair", "--strip", "--only-plat", "--wheel-dir", repaired, wheel)
    run(*command, PATH=path, SOURCE_DATE_EPOCH="315532800")
    (result,) = repaired.glob("*.whl")
    return Wheel(result, tag, needed_libraries(wheel, result, out))


def bundled(wheel: Path) -> list[str]:
    """Names of the libraries inside, as auditwheel renamed them."""
    with zipfile.ZipFile(wheel) as archive:
        names = [Path(name).name for name in archive.namelist() if name.startswith("ifa.libs/")]
    return sorted(name for name in names if ".so" in name)


def needed_libraries(plain: Path, repaired: Path, out: Path) -> tuple[Path, ...]:
    """Where on this machine each bundled library came from, by the loader's own search."""
    with zipfile.ZipFile(plain) as archive:
        (module,) = [name for name in archive.namelist() if name.endswith(".so")]
        extracted = archive.extract(module, out / "module")
    found = {}
    for name, path in re.findall(r"(\S+) => (/\S+)", run("ldd", extracted)):
        found[name.split(".so")[0]] = Path(path).resolve()
    libraries = []
    for name in bundled(repaired):
        stem = re.sub(r"-[0-9a-f]{8}(?=\.so)", "", name).split(".so")[0]
        if stem not in found:
            raise BuildError(f"{repaired.name} holds {name}, and ldd does not say where it is from")
        libraries.append(found[stem])
    return tuple(libraries)
