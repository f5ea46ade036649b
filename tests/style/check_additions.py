#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Counts what a new kind of layer, of dataset or of job, a field of a style, or a reader costs: the files beyond its own that name an existing one.

    check_additions.py ROOT

Prints each file that is not in the list that ARCHITECTURE.md gives ("Where to add"), and exits 1 if there is any.
"""
import pathlib
import re
import sys

# What is added, by an example that there is: words of its code, its own files, and the files that may name it.
ADDITIONS = {
    "a kind of layer": (
        r"\bMeshStyle\b|\bMeshSurface\b|\bMeshEditor\b|\blowerMesh\b|\bLayer::kMesh\b"
        r"|(load_mesh|mesh_layer|mesh_editor|lower_mesh|mesh_surface)\.(h|cpp)",
        (
            "server/data/load_mesh.",
            "server/frames/mesh_layer.",
            "server/render/layers/mesh/",
            "server/frames/ink_layer.",  # draws the same data, here and below
            "server/render/layers/ink/",
            "server/numbers/pick_run.",  # finds what ink draws
            "client/view/layers/mesh_editor.",
        ),
        {
            "protocol/mote.proto",
            "protocol/scene/view.h",
            "protocol/scene/dataset.cpp",
            "server/render/layers/scene.h",
            "server/render/layers/make_frame_plan.cpp",
            "server/frames/layer_kinds.h",
            "client/view/layers/layer_editor.cpp",
        },
    ),
    "a kind of dataset": (
        r"\bimageKind\b|\bImageManifest\b|image/image_kind|Kind\{\"image\"",
        ("storage/image/", "preprocess/image/"),
        {"protocol/mote.proto", "protocol/scene/dataset.cpp", "storage/dataset_kind.h"},
    ),
    "a kind of job": (
        r"\bimageJob\b|\bImageJob\b|(?<!Layer::)\bkImage\b|command_image|add_subdirectory\(image\)",
        ("preprocess/image/", "preprocess/command_image.cpp"),
        {"protocol/mote.proto", "protocol/scene/job_request.cpp", "preprocess/job_kinds.h", "preprocess/CMakeLists.txt"},
    ),
    "a field of a style": (
        r"\bdensity_range\b|\bgradient_opacity\b|\bgradientOpacity\b",
        (
            "protocol/scene/particles_style.",  # what is made of the message for who draws, and who does
            "server/figures/annotate.cpp",
            "protocol/scene/hybrid_style.",
            "server/render/layers/hybrid/",
        ),
        {"protocol/mote.proto"},
    ),
    "a reader of particles": (
        r"\bgdfReader\b|\breadGdf\b|gpt_source",
        ("preprocess/readers/gpt/",),
        {"preprocess/readers/particle_readers.cpp", "preprocess/readers/CMakeLists.txt"},
    ),
}
FOLDERS = ("protocol", "storage", "preprocess", "server", "client")
SUFFIXES = {".h", ".cpp", ".proto", ".txt"}


def sources(root):
    for folder in FOLDERS:
        for path in sorted((root / folder).rglob("*")):
            if path.is_file() and path.suffix in SUFFIXES:
                yield path.relative_to(root).as_posix(), path.read_text(encoding="utf-8")


def main(root):
    files = list(sources(root))
    violations = 0
    for what, (words, own, allowed) in ADDITIONS.items():
        named = {name for name, text in files if re.search(words, text) and not name.startswith(own)}
        for name in sorted(named - allowed):
            print(f"{name}: {what} would have to change it too")
        for name in sorted(allowed - named):
            print(f"{name}: {what} does not change it any more; take it from the list")
        violations += len(named ^ allowed)
        print(f"{what}: {len(named)} existing files")
    return 1 if violations else 0


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    sys.exit(main(pathlib.Path(sys.argv[1])))
