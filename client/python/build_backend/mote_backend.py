# SPDX-License-Identifier: GPL-3.0-or-later
"""Packs the package for pip, with Python's own library alone: so `pip install client/python` fetches nothing.

The hooks are PEP 517's and 660's. A wheel is a zip file with the package, its metadata and a list of all members.
"""
import base64
import hashlib
import pathlib
import re
import shutil
import subprocess
import tarfile
import zipfile

HERE = pathlib.Path(__file__).resolve().parents[1]
PROTO = "protocol/mote.proto"
_WHEEL = "Wheel-Version: 1.0\nGenerator: mote\nRoot-Is-Purelib: true\nTag: py3-none-any\n"
_ENTRY_POINTS = "[jupyter_serverproxy_servers]\nmote = mote.jupyter:setup\n"
_DATE = (1980, 1, 1, 0, 0, 0)


def _said(name):
    """A text of pyproject.toml; Python 3.9 has no reader of TOML."""
    found = re.search(rf'^{name} = "(.*)"$', (HERE / "pyproject.toml").read_text(encoding="utf-8"), re.MULTILINE)
    return found[1]


def _dependencies():
    text = (HERE / "pyproject.toml").read_text(encoding="utf-8")
    return re.findall(r'"([^"]+)"', re.search(r"^dependencies = \[(.*)\]$", text, re.MULTILINE)[1])


def _metadata():
    lines = ["Metadata-Version: 2.1", "Name: mote", f"Version: {_said('version')}", f"Summary: {_said('description')}",
             "License: GPL-3.0-or-later", f"Requires-Python: {_said('requires-python')}"]
    return "\n".join([*lines, *(f"Requires-Dist: {name}" for name in _dependencies())]) + "\n"


def _messages():
    """What the build makes; made here where it was not built and protoc is there."""
    made = HERE / "mote" / "mote.desc"
    root = HERE.parents[1]
    if made.exists():
        return made
    if not (root / PROTO).exists() or not shutil.which("protoc"):
        raise SystemExit(f"{made} is missing: it is made by Mote's build, cmake --build --preset release --target python")
    subprocess.run(["protoc", "--include_imports", f"--descriptor_set_out={made}", PROTO], cwd=root, check=True)
    return made


def _package():
    """The package's files as (name in the wheel, file)."""
    files = [*(HERE / "mote").glob("*.py"), HERE / "mote" / "py.typed", _messages()]
    return [(f"mote/{file.name}", file.read_bytes()) for file in sorted(files)]


def _pack(folder, members):
    info = f"mote-{_said('version')}.dist-info"
    members = [*members, (f"{info}/METADATA", _metadata().encode()), (f"{info}/WHEEL", _WHEEL.encode()),
               (f"{info}/entry_points.txt", _ENTRY_POINTS.encode())]
    record = ""
    name = f"mote-{_said('version')}-py3-none-any.whl"
    with zipfile.ZipFile(pathlib.Path(folder) / name, "w", zipfile.ZIP_DEFLATED) as wheel:
        for member, data in members:
            digest = base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b"=").decode()
            record += f"{member},sha256={digest},{len(data)}\n"
            wheel.writestr(zipfile.ZipInfo(member, _DATE), data, zipfile.ZIP_DEFLATED)
        wheel.writestr(zipfile.ZipInfo(f"{info}/RECORD", _DATE), record + f"{info}/RECORD,,\n")
    return name


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):
    return _pack(wheel_directory, _package())


def build_editable(wheel_directory, config_settings=None, metadata_directory=None):
    _messages()
    return _pack(wheel_directory, [("mote.pth", f"{HERE}\n".encode())])


def build_sdist(sdist_directory, config_settings=None):
    top = f"mote-{_said('version')}"
    with tarfile.open(pathlib.Path(sdist_directory) / f"{top}.tar.gz", "w:gz") as archive:
        for member, _ in _package():
            archive.add(HERE / member, f"{top}/{member}")
        for name in ("pyproject.toml", "build_backend/mote_backend.py"):
            archive.add(HERE / name, f"{top}/{name}")
    return f"{top}.tar.gz"
