"""Runs in Blender: all test_*.py of this folder by unittest, counts into a JSON file."""

from __future__ import annotations

import json
import sys
import unittest
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parents[1] / "addon")]


def select(suite, names):
    for test in suite:
        if isinstance(test, unittest.TestSuite):
            yield from select(test, names)
        elif not names or any(name in test.id() for name in names):
            yield test


def main() -> None:
    *names, report = sys.argv[sys.argv.index("--") + 1 :]
    tests = list(select(unittest.defaultTestLoader.discover(str(HERE), "test_*.py"), names))
    result = unittest.TextTestRunner(stream=sys.stdout, verbosity=2).run(unittest.TestSuite(tests))
    failed = len(result.failures) + len(result.errors) + len(result.unexpectedSuccesses)
    skipped = len(result.skipped)
    counts = {"passed": result.testsRun - failed - skipped, "failed": failed, "skipped": skipped}
    if result.testsRun == 0:
        counts["failed"] = 1  # a driver that finds no test must not pass
    Path(report).write_text(json.dumps(counts))
    sys.exit(1 if counts["failed"] else 0)


main()
