"""Write the tables of ports in docs/subsystems.md anew from the schema of the core: ``python docs/ports.py``."""

import re
from pathlib import Path

ROOT = Path(__file__).parents[1]
SCHEMA = ROOT / "railcli/kernels/assembly_layout.py"
PAGE = ROOT / "docs/subsystems.md"
BEGIN, END = "<!-- ports: begin -->\n", "<!-- ports: end -->"
FIELD = re.compile(r'^        \("(\w+)", "(\w+)"(?:, (\w+))?\),  # (?:(\w+): )?(.*?) ?(?:\[([^\]]+)\])?$')
OF = {"PORT": "Of each axle", "TRAIN": "Of the vehicle"}


def fields(name):
    """Fields of a record: name, type, writer, text, unit."""
    text = SCHEMA.read_text(encoding="utf-8")
    body = text.partition(f"{name} = np.dtype(")[2].partition("    ],\n")[0]
    for line in body.splitlines():
        if match := FIELD.match(line):
            key, kind, size, writer, about, unit = match.groups()
            yield key, kind + (f"[{size}]" if size else ""), writer or "vehicle", about, unit or ""


def tables():
    """The tables as Markdown."""
    lines = []
    for name, words in OF.items():
        lines += [f"{words} (`{name}`):", "", "| port | written by | unit | type | what |", "|---|---|---|---|---|"]
        lines += [
            f"| `{key}` | {writer} | {unit} | {kind} | {about} |" for key, kind, writer, about, unit in fields(name)
        ]
        lines.append("")
    return "\n".join(lines[:-1]) + "\n"


def page():
    """The page with the tables as they should be."""
    before, _, rest = PAGE.read_text(encoding="utf-8").partition(BEGIN)
    return before + BEGIN + tables() + END + rest.partition(END)[2]


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8", newline="\n")
