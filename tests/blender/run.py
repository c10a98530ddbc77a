"""Runs the add-on's tests inside a headless Blender: python tests/blender/run.py [options].

Options: --window also drives a real window under Xvfb; --pictures NAME keeps its pictures as
NAME_idle.png and so on;
--core DIR takes the package ifa from DIR; --blender PATH; any other word chooses tests by name.
--zips DIR also installs the zips of `make extension` from there into clean configurations;
--python PATH, given with it, runs the tests and the extension in the bpy of that Python too.
The last line is "N passed, N failed"; the exit code is 0 only if none failed.
"""

from __future__ import annotations

import argparse
import json
import os
import shutil
import subprocess
import sys
import tempfile
import zipfile
from pathlib import Path

HERE = Path(__file__).resolve().parent
REPOSITORY = HERE.parents[1]
HEADLESS_LIMIT_S = 600
WINDOW_LIMIT_S = 300


def find_core() -> Path | None:
    """The folder of the package ifa with its built module, as this Python or .venv has it."""
    code = "import ifa, ifa._core; print(ifa.__path__[0]); print(ifa._core.__file__)"
    for python in (sys.executable, str(REPOSITORY / ".venv" / "bin" / "python")):
        if shutil.which(python):
            found = subprocess.run([python, "-c", code], capture_output=True, text=True, cwd="/")
            if found.returncode == 0:
                package, module = found.stdout.split("\n")[:2]
                return assemble_core(Path(package), Path(module))
    return None


def assemble_core(package: Path, module: Path) -> Path:
    """A folder with nothing but ifa: Blender must go on using its own numpy."""
    folder = Path(tempfile.mkdtemp(prefix="ifa-core-"))
    skip = shutil.ignore_patterns("__pycache__", "*.so")
    shutil.copytree(package, folder / "ifa", ignore=skip)
    shutil.copy2(module, folder / "ifa" / module.name)
    return folder


def core_of_wheel(extension: Path, python: str) -> Path | None:
    """The core that the extension carries for a Python, unpacked; None if it carries none."""
    code = "import sys; print('cp{}{}'.format(*sys.version_info))"
    tag = subprocess.run([python, "-c", code], capture_output=True, text=True).stdout.strip()
    with zipfile.ZipFile(extension) as archive:
        for name in archive.namelist():
            if name.endswith(".whl") and f"-{tag}-" in name:
                folder = Path(tempfile.mkdtemp(prefix="ifa-core-"))
                with archive.open(name) as wheel, zipfile.ZipFile(wheel) as files:
                    files.extractall(folder)
                return folder
    return None


def clean_environment(folder: Path, core: Path | None) -> dict[str, str]:
    environment = dict(os.environ)
    for name in ("PYTHONPATH", "PYTHONHOME", "VIRTUAL_ENV", "IFA_PYTHONPATH"):
        environment.pop(name, None)
    # A distribution's Blender takes its standard library from the first python3 on the PATH.
    environment["PATH"] = os.pathsep.join(["/usr/bin", "/bin", environment.get("PATH", "")])
    if core is not None:
        environment["IFA_PYTHONPATH"] = str(core)
    environment["PYTHONDONTWRITEBYTECODE"] = "1"
    for name in ("BLENDER_USER_CONFIG", "BLENDER_USER_SCRIPTS", "BLENDER_USER_EXTENSIONS"):
        environment[name] = str(folder / name.lower())
        Path(environment[name]).mkdir()
    return environment


def run_blender(command: list[str], environment: dict[str, str], limit_s: int) -> tuple[int, str]:
    try:
        done = subprocess.run(
            command,
            env=environment,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            timeout=limit_s,
        )
    except subprocess.TimeoutExpired as expired:
        output = expired.stdout or b""
        text = output.decode(errors="replace") if isinstance(output, bytes) else output
        return 124, f"{text}\nBlender ran longer than {limit_s} s."
    return done.returncode, done.stdout


def run_suite(name: str, command: list[str], core: Path | None, limit_s: int) -> dict:
    """Counts of one Blender run. A crash, or a run that reports nothing, is a failure."""
    with tempfile.TemporaryDirectory(prefix="ifa-blender-") as folder:
        report = Path(folder) / "report.json"
        environment = clean_environment(Path(folder), core)
        return _run_suite(name, [*command, str(report)], environment, limit_s, report)


def _run_suite(name, command, environment, limit_s: int, report: Path) -> dict:
    code, output = run_blender(command, environment, limit_s)
    if report.is_file():
        counts = json.loads(report.read_text())
        if code and not counts["failed"]:
            counts["failed"] = 1
    else:
        counts = {"passed": 0, "failed": 1, "skipped": 0}
    print(output if counts["failed"] else "\n".join(_summary(output)))
    print(f"{name}: exit code {code}, {counts}")
    return counts


def _summary(output: str) -> list[str]:
    return [line for line in output.splitlines() if line.endswith("ok") or "skipped" in line]


def offline(command: list[str]) -> list[str]:
    """The command in a network of its own, with nothing in it, where that is permitted."""
    prefix = ["unshare", "--map-root-user", "--net"]
    try:
        permitted = subprocess.run([*prefix, "true"], capture_output=True).returncode == 0
    except FileNotFoundError:
        permitted = False
    if not permitted:
        print("No right to cut the network off: only Python's own connections are refused.")
    return [*prefix, *command] if permitted else command


def inside(*arguments: str | Path) -> list[str]:
    return [str(HERE / "inside.py"), "--", *map(str, arguments)]


def in_blender(blender: str, arguments: list[str]) -> list[str]:
    command = [blender, "-b", "--factory-startup", "--python-exit-code", "3"]
    return [*command, "--python", *arguments]


def run_zips(blender: str, pythons: list[str], zips: Path, names: list[str]) -> list[dict]:
    """The zips of `make extension`, each installed where it is for."""
    counts = []
    for legacy in zips.glob("*legacy*.zip"):
        command = in_blender(blender, inside("--installed", legacy, "--pattern", "zip_legacy.py"))
        counts.append(run_suite(legacy.name, offline(command), None, HEADLESS_LIMIT_S))
    if not counts:
        print(f"Skipped: there is no legacy zip in {zips}, which needs Python 3.11.")
        counts.append({"passed": 0, "failed": 0, "skipped": 1})
    extensions = [path for path in zips.glob("*.zip") if "legacy" not in path.name]
    if len(extensions) != 1:
        print(f"{zips} does not hold one extension: run make extension first.")
        return [*counts, {"passed": 0, "failed": 1, "skipped": 0}]
    for python in pythons:
        counts += run_version(python, extensions[0], names)
    return counts


def run_version(python: str, extension: Path, names: list[str]) -> list[dict]:
    """The tests of the repository's add-on with the zip's core, and the zip itself, in one bpy."""
    if shutil.which(python) is None:
        print(f"Skipped: there is no {python} here (scripts/install.sh bpy311 bpy313).")
        return [{"passed": 0, "failed": 0, "skipped": 1}]
    code = "import bpy; print(bpy.app.version_string)"
    version = subprocess.run([python, "-c", code], capture_output=True, text=True).stdout.split()
    name = f"bpy {version[0]}" if version else python
    core = core_of_wheel(extension, python)
    if core is None:
        print(f"{name}: {extension.name} holds no core for its Python.")
        return [{"passed": 0, "failed": 1, "skipped": 0}]
    try:
        suite = run_suite(name, [python, *inside(*names)], core, HEADLESS_LIMIT_S)
    finally:
        shutil.rmtree(core)
    command = [python, *inside("--installed", extension, "--pattern", "zip_extension.py")]
    return [suite, run_suite(f"{name}, extension", offline(command), None, HEADLESS_LIMIT_S)]


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("names", nargs="*")
    parser.add_argument("--window", action="store_true")
    parser.add_argument("--pictures", type=Path, default=None)
    parser.add_argument("--core", type=Path, default=None)
    parser.add_argument("--zips", type=Path, default=None)
    parser.add_argument("--python", action="append", default=[])
    parser.add_argument("--blender", default=os.environ.get("BLENDER", "blender"))
    options = parser.parse_args()

    blender = shutil.which(options.blender)
    if blender is None:
        print(f"Skipped: there is no '{options.blender}' here (apt-get install blender).")
        print("0 passed, 0 failed")
        return 0
    core = options.core or find_core()
    if core is None:
        print("The package ifa is not built: run make build first.")
        print("0 passed, 1 failed")
        return 1

    try:
        command = in_blender(blender, inside(*options.names))
        counts = [run_suite("headless", command, core.resolve(), HEADLESS_LIMIT_S)]
        if options.window:
            counts.append(run_window(blender, core.resolve(), options.pictures))
    finally:
        if options.core is None:
            shutil.rmtree(core, ignore_errors=True)
    if options.zips:
        zips = options.zips.resolve()
        counts += run_zips(blender, options.python, zips, options.names)
    total = {key: sum(count[key] for count in counts) for key in ("passed", "failed", "skipped")}
    if total["skipped"]:
        print(f"{total['skipped']} skipped")
    print(f"{total['passed']} passed, {total['failed']} failed")
    return 1 if total["failed"] else 0


def run_window(blender: str, core: Path, pictures: Path | None) -> dict:
    xvfb = shutil.which("xvfb-run")
    if xvfb is None:
        print("window: skipped, there is no xvfb-run (apt-get install xvfb)")
        return {"passed": 0, "failed": 0, "skipped": 1}
    with tempfile.TemporaryDirectory(prefix="ifa-window-") as name:
        folder = Path(name)
        os.environ["LIBGL_ALWAYS_SOFTWARE"] = "1"
        picture = (pictures or folder / "window").resolve()
        command = [xvfb, "-a", "-s", "-screen 0 1600x900x24 +extension GLX", blender]
        command += ["--factory-startup", "--enable-event-simulate", "-noaudio"]
        command += ["--window-geometry", "0", "0", "1600", "900"]
        command += ["--python", str(HERE / "window.py"), "--", str(picture)]
        return run_suite("window", command, core, WINDOW_LIMIT_S)


if __name__ == "__main__":
    sys.exit(main())
