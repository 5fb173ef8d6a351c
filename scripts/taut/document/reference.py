"""The entries of case files, as the apps tell them, in the documents.

A document holds `<!-- reference: APP -->` and `<!-- end of reference -->`; between them stands what the
app says of its own groups, or with `COMMON` in the place of an app, what all apps say.
"""

import argparse
import re
import subprocess
from pathlib import Path

from taut.bootstrap import ROOT
from taut.programs import find

COMMON = "COMMON"
DOCUMENTS = (ROOT / "cases/README.md", ROOT / "cases/mechanism/README.md")
SHARED = ("integration", "output", "extreme", "method")
PLACE = re.compile(r"(?s)(<!-- reference: (\w+) -->\n).*?(<!-- end of reference -->\n)")


def said_by(app: str, option: str) -> str:
    """Returns what an app prints."""
    done = subprocess.run([find(app).path, option], capture_output=True, text=True, check=True)
    return done.stdout


def groups(app: str) -> dict[str, str]:
    """Returns the groups of an app's case files, each a heading and a table."""
    parts = re.split(r"(?m)^(?=### `&)", said_by(app, "--help-case=markdown"))
    return {re.match(r"### `&(\w+)`", part)[1]: part.strip() + "\n" for part in parts if part.strip()}


def reference(app: str) -> str:
    """Returns what stands in a document for an app."""
    common = {name: text for name, text in groups("pendulum").items() if name in SHARED}
    if app == COMMON:
        chosen = list(common.values())
    else:
        chosen = [text for name, text in groups(app).items() if common.get(name) != text]
    return "\n" + "\n".join(chosen) + "\n"


def renewed(text: str) -> str:
    """Returns a document with its references as the apps tell them now."""
    return PLACE.sub(lambda place: place[1] + reference(place[2]) + place[3], text)


def main() -> int:
    """Renews the documents."""
    argparse.ArgumentParser(prog="scripts/reference", description=__doc__).parse_args()
    for path in DOCUMENTS:
        path.write_text(renewed(path.read_text(encoding="utf-8")), encoding="utf-8")
        print(path.relative_to(Path.cwd()) if path.is_relative_to(Path.cwd()) else path)
    return 0
