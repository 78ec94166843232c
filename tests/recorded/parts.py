"""Long parts of stored arguments, each stored once, by its hash: many functions are handed the same campaign."""

import hashlib
import json
import os
from collections.abc import Mapping
from functools import cache
from typing import Any

from tests.paths import ROOT

FILE = ROOT / "tests/recorded/parts.json"
LONG = 600  # characters of a part


def text_of(tree: Any) -> str:
    """Return JSON on a line."""
    return json.dumps(tree, separators=(",", ":"), ensure_ascii=False)


def parted(tree: Any, found: dict[str, str]) -> Any:
    """Return a tree whose long parts are replaced by their hashes; their text is put into ``found``."""
    if isinstance(tree, dict):
        tree = {key: parted(each, found) for key, each in tree.items()}
    elif isinstance(tree, list):
        tree = [parted(each, found) for each in tree] if tree and isinstance(tree[0], list | dict) else tree
    else:
        return tree
    if len(text := text_of(tree)) < LONG or ("n" in tree and "v" not in tree):
        return tree
    name = hashlib.sha256(text.encode()).hexdigest()[:12]
    found[name] = text
    return {"#": name}


def whole(tree: Any, of: Mapping[str, str]) -> Any:
    """Return a tree with the parts in their places again."""
    if isinstance(tree, dict):
        if "#" in tree:
            return whole(json.loads(of[tree["#"]]), of)
        return {key: whole(each, of) for key, each in tree.items()}
    if isinstance(tree, list) and any(isinstance(each, list | dict) for each in tree):
        return [whole(each, of) for each in tree]
    return tree


@cache
def parts() -> dict[str, str]:
    """Return the text of each stored part by its hash."""
    lines = FILE.read_text(encoding="utf-8").splitlines()[1:-1] if FILE.exists() else []
    return {line[1:13]: line[15:].rstrip(",") for line in lines}


def write_parts(found: Mapping[str, str]) -> None:
    """Write the parts, a line each."""
    lines = ",\n".join(f'"{name}":{text}' for name, text in sorted(found.items()))
    new = FILE.with_suffix(f".{os.getpid()}")
    new.write_text("{\n" + lines + "\n}\n", encoding="utf-8")
    new.rename(FILE)  # another process that reads them meanwhile has the old ones whole
    parts.cache_clear()
