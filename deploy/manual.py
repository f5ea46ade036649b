#!/usr/bin/env python3
# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes manual pages and the completion of bash from what the programs say with --help.

    manual.py VERSION OUT PROGRAM...

OUT/man/NAME.1 for each program and each of its subcommands, OUT/completions/PROGRAM for bash: one file, and links to
it. Both know what --help knows, so neither can grow old.
"""
import itertools
import os
import pathlib
import re
import subprocess
import sys

# "  --out DIR/NAME.mote REQUIRED   The dataset to make": names, what stands for the value, and the description.
NAMES = r"-[-\w]+(?:,-[-\w]+)*|[A-Z]+|[a-z]+"
ENTRY = re.compile(rf"^ +(?P<names>{NAMES})(?P<value>(?: \S.*?)?)(?:  +(?P<text>\S.*))?$")
DESCRIPTION_COLUMN = 28
CHOICES = re.compile(r"\{([^}]*)\}")
# What is told of a value: limits, and which there are.
CHECKS = re.compile(r" [({].*")


class Entry:
    """An option, an argument or a subcommand."""

    def __init__(self, names, value, text):
        self.names, self.value, self.text = names.split(","), value.strip(), text

    def option(self):
        return self.names[0].startswith("-")

    def choices(self):
        found = CHOICES.search(self.value)
        return found[1].split(",") if found else []

    def shown(self):
        """The value, as a manual page shows it."""
        return CHECKS.sub("", self.value)


class Command:
    """A program or a subcommand, as its --help tells of it."""

    def __init__(self, words, text):
        self.words = words
        self.usage, self.entries, self.subcommands, self.footer = "", [], [], []
        head, _, rest = text.partition("Usage: ")
        self.description = " ".join(head.split())
        lines = rest.splitlines()
        self.usage = lines[0]
        self.read(lines[1:])

    def read(self, lines):
        section = None
        for number, line in enumerate(lines):
            word = line.strip()
            if word in ("Options:", "Positionals:", "Subcommands:"):
                section = word
            elif line.startswith("[Option Group"):
                section = None
            elif line and not line.startswith(" "):
                self.footer = lines[number:]
                return
            elif section and word:
                self.add(section, line)

    def add(self, section, line):
        if line.startswith(" " * DESCRIPTION_COLUMN) and self.last is not None:
            self.last.text = line.strip()
            return
        found = ENTRY.match(line)
        if not found:
            raise SystemExit(f"manual.py: {' '.join(self.words)}: not understood: {line}")
        self.last = Entry(found["names"], found["value"], found["text"] or "")
        (self.subcommands if section == "Subcommands:" else self.entries).append(self.last)

    last = None

    def name(self):
        return "-".join(self.words)


def ask(program, words):
    """A command and all below it. "~" is whose home the reader has."""
    said = subprocess.run([program, *words[1:], "--help"], check=True, capture_output=True, text=True,
                          env={**os.environ, "HOME": "~"}).stdout
    command = Command(words, said)
    commands = [command]
    for below in command.subcommands:
        commands += ask(program, [*words, below.names[0]])
    return commands


def roff(text):
    text = text.replace("\\", "\\e").replace("-", "\\-")
    return "\\&" + text if text.startswith((".", "'")) else text


def paragraphs(lines):
    return [part.split("\n") for part in re.split(r"\n\n+", "\n".join(lines).strip("\n")) if part]


def footer(lines):
    """Paragraphs under EXAMPLES and NOTES; what is indented stays as it is."""
    page, heading = [], None
    for paragraph in paragraphs(lines):
        examples = paragraph[0] in ("Example:", "Examples:")
        wanted = "EXAMPLES" if examples else "NOTES"
        page.append(".PP" if heading == wanted else f".SH {wanted}")
        heading = wanted
        for indented, group in itertools.groupby(paragraph[examples:], lambda line: line.startswith("  ")):
            body = [roff(line.strip()) if not indented else roff(line[2:]) for line in group]
            page += [".RS 2\n.nf", *body, ".fi\n.RE"] if indented else body
    return page


def manual(command, version, others):
    name, words = command.name(), " ".join(command.words)
    description = command.description.removeprefix(f"{words} ").rstrip(".")
    page = [f'.TH {name.upper()} 1 "" "Mote {version}" "Mote"',
            ".SH NAME", f"{roff(name)} \\- {roff(description)}", ".SH SYNOPSIS", f".B {roff(words)}", roff(command.usage.removeprefix(words).strip())]
    for title, entries in (("ARGUMENTS", [e for e in command.entries if not e.option()]),
                           ("OPTIONS", [e for e in command.entries if e.option()]),
                           ("SUBCOMMANDS", command.subcommands)):
        if entries:
            page.append(f".SH {title}")
        for entry in entries:
            value = f" \\fI{roff(entry.shown())}\\fR" if entry.shown() else ""
            names = ", ".join(f"\\fB{roff(name)}\\fR" for name in entry.names)
            page += [".TP", names + value, roff(entry.text) or "\\&"]
    page += footer(command.footer)
    page += [".SH SEE ALSO", ",\n".join(f".BR {roff(other)} (1)" for other in others if other != name)]
    return "\n".join(page) + "\n"


def table(name, rows):
    lines = [f'    ["{key}"]="{" ".join(words)}"' for key, words in rows if words]
    return [f"declare -gA {name}=(", *lines, ")"]


def completion(commands, programs):
    """Tables of what --help says, and the function that looks into them."""
    def key(command):
        return " ".join(command.words)

    options = [(key(c), [e.names[-1] for e in c.entries if e.option()]) for c in commands]
    valued = [(key(c), [e.names[-1] for e in c.entries if e.option() and e.value]) for c in commands]
    below = [(key(c), [e.names[0] for e in c.subcommands]) for c in commands]
    choices = [(f"{key(c)} {e.names[-1]}", e.choices()) for c in commands for e in c.entries]
    return "\n".join(["# SPDX-License-Identifier: GPL-3.0-or-later",
                      "# Completion of Mote's programs for bash, made by deploy/manual.py.",
                      *table("_mote_options", options), *table("_mote_valued", valued),
                      *table("_mote_subcommands", below), *table("_mote_choices", choices), COMPLETE, f"complete -o filenames -F _mote {' '.join(programs)}"]) + "\n"


COMPLETE = r"""
_mote() {
    local word=${COMP_WORDS[COMP_CWORD]} previous=${COMP_WORDS[COMP_CWORD - 1]}
    local command=${1##*/} next i
    for ((i = 1; i < COMP_CWORD; ++i)); do
        next=${COMP_WORDS[i]}
        if [[ " ${_mote_subcommands[$command]-} " == *" $next "* ]]; then command+=" $next"; fi
    done
    local words="${_mote_subcommands[$command]-}" files=yes
    if [[ " ${_mote_valued[$command]-} " == *" $previous "* ]]; then
        words=${_mote_choices["$command $previous"]-}
    elif [[ $word == -* ]]; then
        words=${_mote_options[$command]-}
        files=no
    fi
    mapfile -t COMPREPLY < <(compgen -W "$words" -- "$word")
    if [[ $files == yes && -z $words ]]; then mapfile -t COMPREPLY < <(compgen -f -- "$word"); fi
}"""


def main(arguments):
    if len(arguments) < 3:
        print(__doc__, file=sys.stderr)
        return 2
    version, out, programs = arguments[0], pathlib.Path(arguments[1]), arguments[2:]
    commands = [command for program in programs for command in ask(program, [pathlib.Path(program).name])]
    for folder in ("man", "completions"):
        (out / folder).mkdir(parents=True, exist_ok=True)
    for command in commands:
        page = manual(command, version, [c.name() for c in commands])
        (out / "man" / f"{command.name()}.1").write_text(page, encoding="utf-8")
    names = [pathlib.Path(program).name for program in programs]
    for name in names:
        (out / "completions" / name).write_text(completion(commands, names), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
