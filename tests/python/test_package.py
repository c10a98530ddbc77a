"""The package as a whole: its public names, its errors, and what importing it costs."""

import subprocess
import sys
import threading
from importlib.metadata import entry_points, version

import ifa
import pytest


def test_every_public_name_exists_and_is_documented():
    for name in ifa.__all__:
        value = getattr(ifa, name)
        assert name == "__version__" or value.__doc__, name


def test_version_of_package_and_core_agree():
    assert version("ifa") == ifa.__version__


def test_entry_point_loads():
    (entry,) = entry_points(group="console_scripts", name="ifa")
    assert callable(entry.load())


def test_import_loads_nothing_slow():
    """Reading a mesh or drawing a picture may import a lot; `import ifa` may not."""
    code = """
import sys, ifa
print([name for name in ("matplotlib", "scipy", "trimesh") if name in sys.modules])
"""
    out = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True)
    assert out.stdout.strip() == "[]"


@pytest.mark.parametrize(
    ("error", "bases"),
    [
        (ifa.IfaError, (Exception,)),
        (ifa.IfaValueError, (ifa.IfaError, ValueError)),
        (ifa.IfaFileError, (ifa.IfaError, OSError)),
        (ifa.Cancelled, (ifa.IfaError,)),
    ],
)
def test_errors_are_what_callers_catch(error, bases):
    for base in bases:
        assert issubclass(error, base)
    assert error.__module__ == "ifa"
    assert str(error("mass_kg: must be positive")) == "mass_kg: must be positive"


def test_progress_starts_at_zero_and_cancels_from_any_thread():
    progress = ifa.Progress()
    assert progress.fraction == 0.0
    assert not progress.cancelled
    thread = threading.Thread(target=progress.cancel)
    thread.start()
    thread.join()
    assert progress.cancelled
