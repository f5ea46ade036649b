# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs a notebook's cells in plain Python, as Jupyter would: for tests, and to put the outputs into docs/beam.ipynb.

    MOTE_SERVER=build/release/bin/mote-server PYTHONPATH=client/python python3 tests/python/notebook.py docs/beam.ipynb
"""
import ast
import base64
import contextlib
import io
import json
import pathlib
import sys


def _text(value):
    return value.splitlines(keepends=True)


def bundle(value):
    """What a notebook keeps of a value: as IPython asks for it."""
    if hasattr(value, "_repr_mimebundle_"):
        found = value._repr_mimebundle_()
        data, metadata = found if isinstance(found, tuple) else (found, {})
        data = dict(data)
    else:
        data, metadata = {}, {}
        for mime, name in (("image/png", "_repr_png_"), ("image/svg+xml", "_repr_svg_"), ("text/html", "_repr_html_")):
            if hasattr(value, name):
                data[mime] = getattr(value, name)()
    data.setdefault("text/plain", repr(value))
    for mime, content in data.items():
        if isinstance(content, bytes):
            data[mime] = base64.b64encode(content).decode()
        elif mime.startswith("text/") or mime.endswith("xml"):
            data[mime] = _text(content)
    return data, metadata


def run(source, space, count):
    """The outputs of a cell. What it raises is raised."""
    tree = ast.parse(source)
    last = tree.body.pop() if tree.body and isinstance(tree.body[-1], ast.Expr) else None
    printed = io.StringIO()
    outputs = []
    with contextlib.redirect_stdout(printed):
        exec(compile(tree, f"<cell {count}>", "exec"), space)
        value = eval(compile(ast.Expression(last.value), f"<cell {count}>", "eval"), space) if last else None
    if printed.getvalue():
        outputs.append({"output_type": "stream", "name": "stdout", "text": _text(printed.getvalue())})
    if value is not None:
        data, metadata = bundle(value)
        outputs.append({"output_type": "execute_result", "execution_count": count, "data": data, "metadata": metadata})
    return outputs


def execute(notebook):
    """Runs all cells one after the other and puts their outputs in the place of those that are there."""
    space = {"__name__": "__main__"}
    count = 0
    for cell in notebook["cells"]:
        if cell["cell_type"] != "code":
            continue
        count += 1
        cell["execution_count"] = count
        cell["outputs"] = run("".join(cell["source"]), space, count)
    return space


def main(path):
    place = pathlib.Path(path)
    notebook = json.loads(place.read_text())
    execute(notebook)
    place.write_text(json.dumps(notebook, indent=1, ensure_ascii=False) + "\n")


if __name__ == "__main__":
    main(*sys.argv[1:])
