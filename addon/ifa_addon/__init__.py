# SPDX-License-Identifier: GPL-3.0-or-later
"""Inverse-Foley Animation in Blender: timeline markers in, a keyed rigid-body motion out."""

import atexit

import bpy

from . import core, job, operators, panel, properties

bl_info = {
    "name": "Inverse-Foley Animation",
    "author": "The IFA authors",
    "version": (0, 0, 0),  # `make extension` puts in that of CMakeLists.txt
    "blender": (3, 4, 0),
    "location": "3D View > Sidebar > IFA",
    "description": "Rigid-body motion whose contacts land on the marks of a sound",
    "category": "Animation",
}

_MODULES = (properties, operators, panel)


@bpy.app.handlers.persistent
def _before_load(*_) -> None:
    """A solve belongs to the file it was started in."""
    job.cancel_all()


def _at_exit() -> None:
    job.cancel_all(wait_s=job.EXIT_WAIT_S)


def register() -> None:
    for module in _MODULES:
        module.register()
    bpy.app.handlers.load_pre.append(_before_load)
    atexit.register(_at_exit)


def unregister() -> None:
    atexit.unregister(_at_exit)
    bpy.app.handlers.load_pre.remove(_before_load)
    job.cancel_all(wait_s=job.EXIT_WAIT_S)
    for module in reversed(_MODULES):
        module.unregister()
    core.remove_paths()
