# SPDX-License-Identifier: GPL-3.0-or-later
"""A person before mote-view: a virtual display, a mouse, a keyboard, and eyes that read letters in its pixels.

Nothing here knows the viewer's code: words are found where they stand in the window, drawn by another library in
the same font; what a hand does goes through the X server.
"""
import atexit
import ctypes
import json
import os
import pathlib
import shutil
import signal
import subprocess
import tempfile
import time

import numpy
from PIL import Image, ImageDraw, ImageFont, ImageGrab

FONT = "/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf"
BIN = pathlib.Path(os.environ.get("MOTE_BIN", "build/release/bin"))
PATIENCE = float(os.environ.get("MOTE_PATIENCE", "60"))  # seconds; for what must come at all
XVFB = "/usr/bin/Xvfb"


def missing():
    """What this machine lacks for such a test, or None."""
    for path in (XVFB, FONT, BIN / "mote-view", BIN / "mote-server", BIN / "mote-prep"):
        if not pathlib.Path(path).exists():
            return str(path)
    try:
        ctypes.CDLL("libXtst.so.6")
    except OSError:
        return "libXtst.so.6"
    return None


class Display:
    """A virtual screen that chooses its own number, and the hand on it."""

    def __init__(self, width=1280, height=720):
        self.process = subprocess.Popen([XVFB, "-displayfd", "1", "-screen", "0", f"{width}x{height}x24", "-noreset"],
                                        stdout=subprocess.PIPE, stderr=subprocess.DEVNULL)
        self.name = ":" + self.process.stdout.readline().decode().strip()
        self.x11, self.xtst = ctypes.CDLL("libX11.so.6"), ctypes.CDLL("libXtst.so.6")
        self.x11.XOpenDisplay.restype = ctypes.c_void_p
        self.x11.XOpenDisplay.argtypes = [ctypes.c_char_p]
        self.x11.XStringToKeysym.restype = ctypes.c_ulong
        self.x11.XKeysymToKeycode.argtypes = [ctypes.c_void_p, ctypes.c_ulong]
        self.x11.XDefaultRootWindow.argtypes = [ctypes.c_void_p]
        self.x11.XDefaultRootWindow.restype = self.x11.XInternAtom.restype = ctypes.c_ulong
        self.x11.XInternAtom.argtypes = [ctypes.c_void_p, ctypes.c_char_p, ctypes.c_int]
        self.x11.XQueryTree.argtypes = [ctypes.c_void_p, ctypes.c_ulong] + [ctypes.c_void_p] * 4
        self.x11.XSendEvent.argtypes = [ctypes.c_void_p, ctypes.c_ulong, ctypes.c_int, ctypes.c_long, ctypes.c_void_p]
        self.x11.XSync.argtypes = [ctypes.c_void_p, ctypes.c_int]
        self.x11.XGetGeometry.argtypes = [ctypes.c_void_p, ctypes.c_ulong] + [ctypes.c_void_p] * 7
        self.x11.XClearArea.argtypes = [ctypes.c_void_p, ctypes.c_ulong] + [ctypes.c_int] * 5
        for call in ("XTestFakeKeyEvent", "XTestFakeButtonEvent"):
            getattr(self.xtst, call).argtypes = [ctypes.c_void_p, ctypes.c_uint, ctypes.c_int, ctypes.c_ulong]
        self.xtst.XTestFakeMotionEvent.argtypes = [ctypes.c_void_p] + [ctypes.c_int] * 3 + [ctypes.c_ulong]
        self.x11.XGetImage.restype = ctypes.c_void_p
        where = [ctypes.c_void_p, ctypes.c_ulong, ctypes.c_int, ctypes.c_int, ctypes.c_uint, ctypes.c_uint, ctypes.c_ulong,
                 ctypes.c_int]
        self.x11.XGetImage.argtypes = where
        self.x11.XGetSubImage.argtypes = where + [ctypes.c_void_p, ctypes.c_int, ctypes.c_int]
        self.x11.XGetPixel.restype = ctypes.c_ulong
        self.x11.XGetPixel.argtypes = [ctypes.c_void_p, ctypes.c_int, ctypes.c_int]
        self.dot = None
        self.handle = self.x11.XOpenDisplay(self.name.encode())

    def close(self):
        self.process.terminate()
        self.process.wait()

    def _sync(self):
        self.x11.XSync(self.handle, 0)

    def move(self, x, y):
        self.xtst.XTestFakeMotionEvent(self.handle, -1, round(x), round(y), 0)
        self._sync()

    def button(self, number, down):
        self.xtst.XTestFakeButtonEvent(self.handle, number, int(down), 0)
        self._sync()

    def _windows(self):
        root = self.x11.XDefaultRootWindow(self.handle)
        one, other, count = ctypes.c_ulong(), ctypes.c_ulong(), ctypes.c_uint()
        children = ctypes.POINTER(ctypes.c_ulong)()
        self.x11.XQueryTree(self.handle, root, ctypes.byref(one), ctypes.byref(other), ctypes.byref(children),
                            ctypes.byref(count))
        return [children[i] for i in range(count.value)]

    def close_window(self):
        """Tells each window what its close button would."""
        atom = lambda name: self.x11.XInternAtom(self.handle, name, 0)
        for window in self._windows():
            event = (ctypes.c_long * 24)()  # XClientMessageEvent
            for at, value in ((0, 33), (4, window), (5, atom(b"WM_PROTOCOLS")), (6, 32), (7, atom(b"WM_DELETE_WINDOW"))):
                event[at] = value
            self.x11.XSendEvent(self.handle, window, 0, 0, ctypes.byref(event))
        self._sync()

    def resize(self, width, height):
        for window in self._windows():
            self.x11.XResizeWindow(ctypes.c_void_p(self.handle), ctypes.c_ulong(window), width, height)
        self._sync()

    def pixel(self, x, y):
        """What is on the screen there, as one number."""
        place = (self.handle, self.x11.XDefaultRootWindow(self.handle), int(x), int(y), 1, 1, 0xffffff, 2)
        if self.dot is None:
            self.dot = self.x11.XGetImage(*place)
        else:
            self.x11.XGetSubImage(*place, self.dot, 0, 0)
        return self.x11.XGetPixel(self.dot, 0, 0)

    def expose(self):
        """Blackens each window and tells it that it is to be drawn again, as after another one before it."""
        numbers = [ctypes.c_ulong()] + [ctypes.c_uint() for _ in range(6)]  # the last is the depth; 0: not to be seen
        for window in self._windows():
            self.x11.XGetGeometry(self.handle, window, *map(ctypes.byref, numbers))
            if numbers[-1].value > 0:
                self.x11.XClearArea(self.handle, window, 0, 0, 0, 0, 1)
        self._sync()

    def key(self, name, down):
        code = self.x11.XKeysymToKeycode(self.handle, self.x11.XStringToKeysym(name.encode()))
        assert code, name
        self.xtst.XTestFakeKeyEvent(self.handle, code, int(down), 0)
        self._sync()


SHIFTED = dict(zip('~!@#$%^&*()_+{}|:"<>?', "`1234567890-=[]\\;',./"))
NAMES = {" ": "space", "-": "minus", ".": "period", "/": "slash", ",": "comma", "=": "equal", "[": "bracketleft",
         "]": "bracketright", ";": "semicolon", "'": "apostrophe", "`": "grave", "\\": "backslash"}


def word_picture(word, size):
    """Grey letters as the viewer's font gives them at `size` pixels, without hinting and kerning."""
    fine = 8
    ascent, descent, em = 1901, 483, 2048  # of DejaVu Sans
    scale = size / (ascent + descent)
    font = ImageFont.truetype(FONT, round(em * scale * fine), layout_engine=ImageFont.Layout.BASIC)
    width = sum(font.getlength(letter) for letter in word)
    picture = Image.new("L", ((int(width) // fine + 2) * fine, size * fine))
    draw = ImageDraw.Draw(picture)
    at = 0.0
    for letter in word:
        draw.text((at, round(ascent * scale * fine)), letter, fill=255, font=font, anchor="ls")
        at += font.getlength(letter)
    return numpy.asarray(picture, float).reshape(size, fine, -1, fine).mean((1, 3))


def fast_length(least):
    """The next length whose transform is fast."""
    while True:
        left = least
        for factor in (2, 3, 5):
            while left % factor == 0:
                left //= factor
        if left == 1:
            return least
        least += 1


def find_pattern(grey, pattern):
    """How like the pattern each place of the window is, by its upper left: normalised correlation."""
    rows, columns = pattern.shape
    shape = [fast_length(side) for side in grey.shape]  # what wraps around is cut off
    pattern = pattern - pattern.mean()
    transform = lambda a: numpy.fft.rfft2(a, shape)
    whole = numpy.fft.irfft2(transform(grey) * numpy.conj(transform(pattern)), shape)
    cross = whole[:grey.shape[0] - rows + 1, :grey.shape[1] - columns + 1]

    def boxes(a):
        sums = numpy.pad(a.cumsum(0).cumsum(1), ((1, 0), (1, 0)))
        return sums[rows:, columns:] - sums[:-rows, columns:] - sums[rows:, :-columns] + sums[:-rows, :-columns]

    spread = boxes(grey * grey) - boxes(grey) ** 2 / pattern.size
    return cross / numpy.sqrt(numpy.maximum(spread, 1e3) * (pattern * pattern).sum())


SHOTS = ("unseen.png", "failed.png")  # what a test that failed leaves to be looked at


def new_folder():
    """A folder that goes when this program ends, unless the picture of a failure lies in it."""
    folder = pathlib.Path(tempfile.mkdtemp(prefix="mote-desk-"))

    def remove():
        if not any((folder / name).exists() for name in SHOTS):
            shutil.rmtree(folder, ignore_errors=True)
    atexit.register(remove)
    return folder


class Viewer:
    """mote-view in a window of its own display."""

    def __init__(self, arguments, size=(1280, 720), state=None, display=None, home=None, **environment):
        self.size = size
        self.display = display or Display(*size)
        self.own = display is None
        self.folder = pathlib.Path(state) if state else new_folder()
        self.log = open(self.folder / "said", "w+", encoding="utf-8")
        environment = {**os.environ, "DISPLAY": self.display.name, "XDG_STATE_HOME": str(self.folder / "state"),
                       "XDG_CACHE_HOME": str(self.folder / "cache"), "HOME": str(home or self.folder), "WAYLAND_DISPLAY": "",
                       **environment}
        self.process = subprocess.Popen([str(BIN.resolve() / "mote-view"), "--size", f"{size[0]}x{size[1]}",
                                         *map(str, arguments)],
                                        env=environment, cwd=self.folder, stderr=self.log)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def close(self):
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGKILL)
        self.process.wait()
        self.log.close()
        if self.own:
            self.display.close()

    def processor(self):
        """Seconds that it has taken of a core."""
        fields = pathlib.Path(f"/proc/{self.process.pid}/stat").read_text(encoding="ascii").rsplit(")", 1)[1].split()
        return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")

    def rests(self, most):
        """Waits until it takes no more than so many seconds of a core in two."""
        def check():
            before = self.processor()
            time.sleep(2.0)
            return self.processor() - before <= most + 1e-9
        self.until(check, "rest")

    def said(self):
        self.log.seek(0)
        return self.log.read()

    def desk(self):
        """What the viewer keeps of its work, as its file has it: subject, views, film, and, where there are several
        panes, their views, which is active, what is linked; None before there is any."""
        for path in (self.folder / "state" / "mote").glob(f"*-{self.process.pid}.session"):
            lines = path.read_text(encoding="utf-8").splitlines()
            kept = {"subject": lines[1].removeprefix("subject "), "views": {}, "film": None, "panes": [], "active": 0,
                    "links": []}
            for head, content in zip(lines[2::2], lines[3::2]):
                if head == "film":
                    kept["film"] = json.loads(content)
                elif head.startswith("panes "):
                    kept["active"], kept["links"] = int(head.removeprefix("panes ")), content.split()
                elif head.startswith("pane "):
                    kept["panes"].append(json.loads(content))
                else:
                    kept["views"][head.removeprefix("view ")] = json.loads(content)
            return kept
        return None

    def view(self):
        """The view that is shown, as JSON; {} before anything was done."""
        kept = self.desk()
        return kept["views"][kept["subject"]] if kept else {}

    def shows(self, holds, what="that view"):
        """Waits until the view holds; before anything was done there is none."""
        def check():
            view = self.view()
            return view if view and holds(view) else None
        return self.until(check, what)

    def panes(self):
        """The views of all panes; [] while there is one."""
        kept = self.desk()
        return kept["panes"] if kept else []

    # Eyes.

    def picture(self):
        """What is on the screen: rows x columns x RGB."""
        return numpy.asarray(ImageGrab.grab(xdisplay=self.display.name).convert("RGB"))

    def where(self, word, within=None, nth=0, least=0.8, size=14):
        """The middle of a word on the screen, or None. `within`: left, top, right, bottom. `nth`: from above."""
        left, top, right, bottom = within or (0, 0, *self.size)
        grey = self.picture()[top:bottom, left:right].astype(float).max(2)
        pattern = word_picture(word, size)
        like = numpy.abs(find_pattern(grey, pattern))  # dark letters on light ground too
        found = []
        for y, x in sorted(zip(*numpy.nonzero(like > least)), key=lambda at: -like[at]):
            if all(abs(y - fy) > 6 or abs(x - fx) > 6 for fy, fx in found):
                found.append((y, x))
        found.sort()
        if len(found) <= nth:
            return None
        y, x = found[nth]
        return left + x + pattern.shape[1] // 2, top + y + size // 2

    def see(self, word, patience=PATIENCE, **how):
        """The same, once it is there, and stays where it is for two looks."""
        end = time.monotonic() + patience
        before = None
        while time.monotonic() < end:
            at = self.where(word, **how)
            if at and at == before:
                return at
            before = at
            self.alive()
            time.sleep(0.05)
        self.keep(SHOTS[0])
        raise AssertionError(f"'{word}' is not to be seen; see {self.folder}/{SHOTS[0]}")

    def keep(self, name):
        Image.fromarray(self.picture()).save(self.folder / name)

    def alive(self):
        if self.process.poll() is not None:
            raise AssertionError(f"mote-view ended, {self.process.returncode}: {self.said()}")

    def until(self, holds, what="that", patience=PATIENCE):
        """Waits until `holds()` is something, and returns it."""
        end = time.monotonic() + patience
        while time.monotonic() < end:
            got = holds()
            if got:
                return got
            self.alive()
            time.sleep(0.02)
        self.keep(SHOTS[1])
        raise AssertionError(f"{what} did not come; see {self.folder}/{SHOTS[1]}")

    # Hands.

    def move(self, x, y):
        self.display.move(x, y)

    def click(self, x, y, button=1):
        self.move(x, y)
        time.sleep(0.1)  # a hand rests before it presses
        self.display.button(button, True)
        time.sleep(0.1)
        self.display.button(button, False)
        time.sleep(0.1)

    def press(self, word, **how):
        """Clicks on a word that is to be seen."""
        self.click(*self.see(word, **how))

    def drag(self, begin, end, button=1, steps=8):
        self.move(*begin)
        time.sleep(0.1)
        self.display.button(button, True)
        for i in range(1, steps + 1):
            time.sleep(0.03)
            self.move(*(b + (e - b) * i / steps for b, e in zip(begin, end)))
        time.sleep(0.1)
        self.display.button(button, False)
        time.sleep(0.1)

    def wheel(self, x, y, turns):
        self.move(x, y)
        for _ in range(abs(turns)):
            self.display.button(4 if turns > 0 else 5, True)
            self.display.button(4 if turns > 0 else 5, False)
            time.sleep(0.03)

    def key(self, keys):
        """"ctrl+shift+z"."""
        *held, last = keys.split("+") if keys != "+" else [keys]
        if last in SHIFTED:
            held.append("shift")
            last = SHIFTED[last]
        names = [{"ctrl": "Control_L", "shift": "Shift_L", "alt": "Alt_L"}[each] for each in held]
        for name in names:
            self.display.key(name, True)
        name = NAMES.get(last, last)
        self.display.key(name, True)
        time.sleep(0.015)  # no finger is faster
        self.display.key(name, False)
        for name in reversed(names):
            self.display.key(name, False)
        time.sleep(0.015)

    def type(self, text):
        for letter in text:
            self.key("shift+" + letter.lower() if letter.isupper() else letter)
            time.sleep(0.02)


    def do(self, command):
        """Asks for a command by its name."""
        self.key("ctrl+k")
        self.see("type what you want to do")
        self.type(command.lower())
        self.see(command, within=(self.size[0] // 2 - 230, 90, self.size[0] // 2 + 230, 340))
        self.key("Return")
        self.gone("type what you want to do")

    def gone(self, word, **how):
        """Waits until a word is to be seen no more."""
        self.until(lambda: self.where(word, **how) is None, f"the end of '{word}'")

    def ask_to_close(self):
        """What a window's close button does."""
        self.display.close_window()


class Server:
    """A server on a Unix socket, with its data; for a ``with`` statement."""

    def __init__(self, folder, data):
        self.folder = pathlib.Path(folder)
        self.connection = self.folder / "connection.json"
        with open(self.folder / "server.log", "w", encoding="utf-8") as log:
            self.process = subprocess.Popen(
                [str(BIN / "mote-server"), "--root", f"data={data}", "--state", str(self.folder / "server"),
                 "--connection", str(self.connection), "--device", "cpu"], stdout=subprocess.PIPE, stderr=log)
        if not self.process.stdout.readline().startswith(b"ready"):
            raise RuntimeError((self.folder / "server.log").read_text(encoding="utf-8"))

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def close(self):
        self.process.terminate()
        self.process.wait()
        self.process.stdout.close()
