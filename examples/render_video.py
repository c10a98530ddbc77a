# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs inside Blender: the scene of a .blend, with the sound of its sequencer, as an mp4.

    blender -b scene.blend --python examples/render_video.py -- OUT.mp4 [WIDTH HEIGHT]

Workbench with shadows: a solved roll of two seconds takes about half a minute without a GPU.
"""

from __future__ import annotations

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "addon"))

import bpy
from ifa_addon import compat


def main() -> None:
    out, *size = sys.argv[sys.argv.index("--") + 1 :]
    target = bpy.context.scene
    render = target.render
    render.engine = "BLENDER_WORKBENCH"
    shading = target.display.shading
    shading.light, shading.color_type = "STUDIO", "MATERIAL"
    shading.show_shadows, shading.show_cavity = True, True
    shading.shadow_intensity = 0.4
    target.display.light_direction = (-0.25, -0.35, -0.9)
    target.view_settings.view_transform, target.view_settings.exposure = "Standard", 0.9
    render.resolution_x, render.resolution_y = (int(n) for n in size or (960, 540))
    render.resolution_percentage = 100
    # The 3D scene is the picture, the sequencer only the sound.
    render.use_sequencer = True
    compat.write_mp4(render, str(Path(out).resolve()))
    bpy.ops.render.render(animation=True)
    print(f"written {out}")


main()
