#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""How long mote-view takes, in a real window of a virtual display: docs/VIEWER.md has the table.

    MOTE_BIN=build/release/bin measure.py PART...

Parts: file, connect, frozen, dead, slow, large, small, many, files, rest, views. How soon the interface answers is the time from
a move of the pointer to the light of what lies under it, on the screen. Frames that fill the window are counted by
Mesa (GALLIUM_HUD); those that draw a part of it are not.
"""
import os
import pathlib
import shutil
import signal
import statistics
import subprocess
import sys
import tempfile
import threading
import time

HUD = pathlib.Path(tempfile.mkdtemp(prefix="mote-desk-frames-"))
os.environ.update(GALLIUM_HUD="frametime", GALLIUM_HUD_DUMP_DIR=str(HUD), GALLIUM_HUD_PERIOD="0", GALLIUM_HUD_VISIBLE="false")

import numpy  # noqa: E402

import hand  # noqa: E402
from desk_case import data, warm  # noqa: E402

OPEN = []  # what is to be closed, whatever comes
PARTICLES = {"file": 1_000_000, "connect": 10_000_000}


def prepare(*arguments):
    subprocess.run([hand.BIN / "mote-prep", *map(str, arguments)], check=True, stdout=subprocess.DEVNULL,
                   stderr=subprocess.DEVNULL)


def run_of(particles, folder):
    path = folder / "run.h5"
    prepare("synth", "beam", "--particles", particles, "--steps", 1, "--seed", 1, "--out", path)
    return path


def until_useful(arguments, **how):
    """Seconds from the command to a beam on the screen."""
    display = hand.Display(1280, 720)
    begin = time.monotonic()
    viewer = hand.Viewer(arguments, display=display, **how)
    viewer.until(lambda: warm(viewer.picture()[:, :940]).sum() > 2000, "the beam", patience=300)
    taken = time.monotonic() - begin
    viewer.close()
    display.close()
    return taken


def frames():
    return [float(line) for path in HUD.iterdir() for line in path.read_text(encoding="ascii").split()]


def answer(viewer, say, places=None, count=100):
    """Moves the pointer to and fro between two places, and says how soon they are lit."""
    width = viewer.size[0]
    band = (width - 340, 0, width, 40)
    places = places or [viewer.see(word, within=band) for word in ("Undo", "Redo")]
    seen = []
    for place in places:
        viewer.move(*place)
        time.sleep(2.0)
        seen.append(viewer.picture())
    (x, y), (left, top) = places[0], (max(places[0][0] - 30, 0), max(places[0][1] - 12, 0))
    lit = (seen[0] != seen[1])[top:y + 12, left:x + 30].any(2)
    at = numpy.argwhere(lit)[len(numpy.argwhere(lit)) // 2]
    at = (left + at[1], top + at[0])
    taken, spent = [], viewer.processor()
    for _ in range(count // 2):
        for place in places:
            before = viewer.display.pixel(*at)
            begin = time.monotonic()
            viewer.move(*place)
            while viewer.display.pixel(*at) == before:
                if time.monotonic() - begin > 10:
                    raise RuntimeError("the interface does not answer")
                time.sleep(0.0002)
            taken.append(1000 * (time.monotonic() - begin))
            time.sleep(0.02)
    spent = viewer.processor() - spent
    taken.sort()
    print(f"{say}: answers within {statistics.median(taken):.1f} ms, 95% within {taken[int(0.95 * len(taken))]:.1f} ms, longest "
          f"{taken[-1]:.1f} ms; {1000 * spent / len(taken):.1f} ms of a core each; load {os.getloadavg()[0]:.1f}", flush=True)


def drag(viewer, say, seconds=4.0):
    """Turns the picture faster than frames come, and says what that takes."""
    width, height = viewer.size
    time.sleep(0.5)
    before, spent = len(frames()), viewer.processor()
    viewer.move(width // 3, height // 2)
    viewer.display.button(1, True)
    end = time.monotonic() + seconds
    step = 0
    while time.monotonic() < end:
        step += 1
        viewer.move(step % 100 + width // 3, height // 2 + step % 37)
        time.sleep(0.001)
    viewer.display.button(1, False)
    spent = viewer.processor() - spent
    print(f"{say}: {100 * spent / seconds:.0f}% of a core, {(len(frames()) - before) / seconds:.0f} whole windows a second",
          flush=True)


def processes(server):
    children = subprocess.run(["pgrep", "-P", str(server.process.pid)], capture_output=True, text=True, check=False).stdout
    return [server.process.pid, *map(int, children.split())]


def tell(server, what):
    for process in processes(server):
        os.kill(process, what)


def shown(folder, root, size=(1280, 720)):
    server = hand.Server(folder, root)
    OPEN.append(server)
    viewer = hand.Viewer(["--connect", server.connection], size=size)
    OPEN.append(viewer)
    viewer.see("exact", within=(size[0] - 340, 60, size[0], 110))
    return server, viewer


def part_file(folder):
    path = run_of(PARTICLES["file"], folder)
    state = hand.new_folder()
    print(f"mote-view run.h5, {PARTICLES['file']:,} particles, to a useful picture: {until_useful([path], state=state):.2f} s")
    print(f"again, prepared: {until_useful([path], state=state):.2f} s")


def part_connect(folder):
    root = folder / "root"
    root.mkdir()
    prepare("particles", run_of(PARTICLES["connect"], folder), "--axes", "x,px,y", "--out", root / "beam.mote")
    with hand.Server(folder, root) as server:
        for what in ("first", "again"):
            taken = until_useful(["--connect", server.connection])
            print(f"mote-view --connect, {PARTICLES['connect']:,} particles, {what}: {taken:.2f} s", flush=True)


def part_views(folder):
    _, viewer = shown(folder, data())
    for count in (1, 4):
        viewer.key(f"ctrl+{count}")
        time.sleep(3)
        answer(viewer, f"{count} views")
        drag(viewer, f"{count} views, a drag turns one")
    viewer.do("Link or unlink cameras")
    drag(viewer, "4 views, a drag turns all")
    rest(viewer, "4 views")


def part_frozen(folder):
    server, viewer = shown(folder, data())
    answer(viewer, "well")
    drag(viewer, "well, a drag turns the picture")
    tell(server, signal.SIGSTOP)
    answer(viewer, "frozen server")
    drag(viewer, "frozen server, a drag")
    tell(server, signal.SIGCONT)


def part_dead(folder):
    server, viewer = shown(folder, data())
    server.close()
    viewer.see("Connect now", within=(0, 0, 940, 720))
    answer(viewer, "dead server, said on the picture")


def part_slow(folder):
    server, viewer = shown(folder, data())
    running = True

    def starve():
        while running:
            tell(server, signal.SIGSTOP)
            time.sleep(0.18)
            tell(server, signal.SIGCONT)
            time.sleep(0.02)

    thread = threading.Thread(target=starve)
    thread.start()
    drag(viewer, "server that runs a tenth of the time, a drag")
    running = False
    thread.join()


def part_large(folder):
    for size in ((1280, 720), (1920, 1080), (3840, 2160), (7680, 4320)):
        where = folder / str(size[0])
        where.mkdir()
        _, viewer = shown(where, data(), size)
        answer(viewer, f"window of {size[0]} x {size[1]}")
        while OPEN:
            OPEN.pop().close()


def part_small(folder):
    server, viewer = shown(folder, data())
    viewer.display.resize(1, 1)
    time.sleep(2)
    viewer.alive()
    viewer.display.resize(1280, 720)
    viewer.see("exact", within=(940, 60, 1280, 110))
    print("window of 1 x 1 and back: it shows the exact picture again")


def part_many(folder):
    root = folder / "root"
    root.mkdir()
    for i in range(10_000):
        shutil.copytree(data() / "magnet.mote", root / f"run-{i:05}.mote", copy_function=os.link)
    shutil.copytree(data() / "beam.mote", root / "beam.mote", copy_function=os.link)
    begin = time.monotonic()
    server, viewer = shown(folder, root)
    print(f"10,001 datasets: {time.monotonic() - begin:.2f} s to server, window and exact picture", flush=True)
    answer(viewer, "10,001 datasets")
    viewer.key("d")
    viewer.see("10001 of 10001", within=(0, 80, 940, 720))
    answer(viewer, "their list", [(400, 300), (400, 420)])
    spent = viewer.processor()
    for _ in range(60):
        viewer.wheel(400, 400, -1)
        time.sleep(0.03)
    viewer.type("run 0123")
    viewer.see("10 of 10001", within=(0, 80, 940, 720))
    print(f"60 turns of the wheel and eight letters: {1000 * (viewer.processor() - spent):.0f} ms of a core")


def part_files(folder):
    root = folder / "root"
    shutil.copytree(data(), root)
    (root / "many").mkdir()
    for i in range(10_000):
        (root / "many" / f"scan_{i}.h5").touch()
    _, viewer = shown(folder, root)
    files = (0, 110, 445, 650)
    viewer.key("shift+d")
    viewer.press("many/", within=files)
    viewer.see("10000 of 10000", within=(0, 80, 940, 720))
    answer(viewer, "list of 10,000 files", [(150, 300), (150, 420)])
    spent = viewer.processor()
    for _ in range(60):
        viewer.wheel(150, 400, -1)
        time.sleep(0.03)
    viewer.type("scan 12")
    viewer.see("of 10000", within=(0, 80, 940, 720))
    print(f"60 turns of the wheel and seven letters: {1000 * (viewer.processor() - spent):.0f} ms of a core")


def rest(viewer, say):
    time.sleep(5)
    before, drawn = viewer.processor(), len(frames())
    time.sleep(20)
    print(f"{say} at rest: {100 * (viewer.processor() - before) / 20:.2f}% of a core, {len(frames()) - drawn} frames in 20 s")


def part_rest(folder):
    _, viewer = shown(folder, data())
    rest(viewer, "one view")


if __name__ == "__main__":
    for part in sys.argv[1:]:
        for old in HUD.iterdir():
            old.unlink()
        folder = hand.new_folder()
        try:
            globals()["part_" + part](folder)
        finally:
            while OPEN:
                OPEN.pop().close()
    shutil.rmtree(HUD)
