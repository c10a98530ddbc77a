"""What enabling and disabling the add-on again and again may leave behind: nothing."""

from __future__ import annotations

import inspect
import sys
import threading

import addon_utils
import bpy

CYCLES = 20


def timers(package: str) -> list[str]:
    """Functions of the add-on that Blender would still call; it does not list its timers."""
    return [
        f"{name}.{function.__name__}"
        for name, module in sys.modules.items()
        if module is not None and (name == package or name.startswith(package + "."))
        for _, function in inspect.getmembers(module, inspect.isfunction)
        if bpy.app.timers.is_registered(function)
    ]


def state(package: str) -> dict:
    handlers = {
        name: len(getattr(bpy.app.handlers, name))
        for name in dir(bpy.app.handlers)
        if isinstance(getattr(bpy.app.handlers, name), list)
    }
    owners = (
        bpy.types.Object,
        bpy.types.Scene,
        bpy.types.TimelineMarker,
        bpy.types.WindowManager,
    )
    return {
        "handlers": handlers,
        "timers": timers(package),
        "classes": [name for name in dir(bpy.types) if name.lower().startswith("ifa_")],
        "properties": [(o.__name__, n) for o in owners for n in dir(o) if n.startswith("ifa")],
        "threads": threading.active_count(),
        "path": list(sys.path),
    }


def check(case, package: str) -> None:
    """Enable and disable `package` CYCLES times, each time with the core loaded and Live on."""
    addon_utils.enable(package)
    addon_utils.disable(package)
    before = state(package)
    for _ in range(CYCLES):
        module = addon_utils.enable(package)
        case.assertIsNotNone(module)
        case.assertTrue(hasattr(bpy.types, "IFA_PT_main"))
        module.core.load()
        bpy.context.window_manager.ifa_live = True
        case.assertTrue(timers(package))
        addon_utils.disable(package)
        case.assertEqual(module.overlay._handles, [])
    case.assertEqual(state(package), before)
    for kind in ("timers", "classes", "properties"):
        case.assertEqual(before[kind], [])
