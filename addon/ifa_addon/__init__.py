# SPDX-License-Identifier: GPL-3.0-or-later
"""Inverse-Foley Animation in Blender: timeline markers in, a keyed rigid-body motion out."""

import atexit

import bpy

from . import (
    core,
    job,
    live,
    marking,
    overlay,
    panel,
    preferences,
    presets,
    properties,
    repairs,
    results,
    solving,
)

bl_info = {
    "name": "Inverse-Foley Animation",
    "author": "The IFA authors",
    "version": (0, 0, 0),  # `make extension` puts in that of CMakeLists.txt
    "blender": (3, 4, 0),
    "location": "3D View > Sidebar > IFA",
    "description": "Rigid-body motion whose contacts land on the marks of a sound",
    "category": "Animation",
}

# In this order: properties come first, panels name operators.
_MODULES = (preferences, properties, solving, marking, repairs, live, presets, panel, overlay)


@bpy.app.handlers.persistent
def _before_load(*_) -> None:
    """A solve belongs to the file it was started in, and so do its motions."""
    live.stop()
    job.cancel_all()
    results.forget()


def _at_exit() -> None:
    job.cancel_all(wait_s=job.EXIT_WAIT_S)


def register() -> None:
    for module in _MODULES:
        for cls in getattr(module, "CLASSES", ()):
            bpy.utils.register_class(cls)
        if hasattr(module, "start"):
            module.start()
    bpy.app.handlers.load_pre.append(_before_load)
    atexit.register(_at_exit)


def unregister() -> None:
    atexit.unregister(_at_exit)
    bpy.app.handlers.load_pre.remove(_before_load)
    job.cancel_all(wait_s=job.EXIT_WAIT_S)
    results.forget()
    for module in reversed(_MODULES):
        if hasattr(module, "stop"):
            module.stop()
        for cls in reversed(getattr(module, "CLASSES", ())):
            bpy.utils.unregister_class(cls)
    core.remove_paths()
