"""What MkDocs calls while it builds the site: adds the reference pages, and mends links that lead out of ``docs``."""

from __future__ import annotations

import html
import re
import sys
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT / "scripts")]  # MkDocs loads this file by its path

from latex2mathml.converter import convert  # noqa: E402
from mkdocs.structure.files import File, Files  # noqa: E402

from docs_site.reference import pages  # noqa: E402

INLINE = re.compile(r'<span class="arithmatex">\\\((.*?)\\\)</span>', re.DOTALL)
DISPLAY = re.compile(r'<div class="arithmatex">\s*\\\[(.*?)\\\]\s*</div>', re.DOTALL)
LINK = re.compile(r"\[([^\]]+)\]\(((?:\.\./)+[^)#\s]+)(#[^)]*)?\)")


def on_config(config: Any) -> Any:
    """Put all decision records into the navigation, in their order."""
    records = sorted(Path(config.docs_dir, "decisions").glob("*.md"))
    config.nav.append({"Decisions": [f"decisions/{record.name}" for record in records]})
    return config


def on_files(files: Files, config: Any) -> Files:
    """Add the pages that follow from the code."""
    for path, text in pages().items():
        files.append(File.generated(config, path, content=text))
    return files


def on_page_markdown(markdown: str, page: Any, config: Any, **_: Any) -> str:
    """Return a page in which links to files outside the site lead to the repository, or name the file."""
    folder = Path(config.docs_dir, page.file.src_uri).parent

    def mended(match: re.Match[str]) -> str:
        target = (folder / match[2]).resolve()
        if target.is_relative_to(config.docs_dir) or not target.is_relative_to(ROOT):
            return match[0]
        path = str(target.relative_to(ROOT))
        return f"[{match[1]}]({config.repo_url}/blob/main/{path})" if config.repo_url else f"{match[1]} (`{path}`)"

    return LINK.sub(mended, markdown)


def on_page_content(content: str, **_: Any) -> str:
    """Return a page whose equations are MathML, which browsers show without a script and without the network."""
    content = DISPLAY.sub(lambda match: convert(html.unescape(match[1]).strip(), display="block"), content)
    return INLINE.sub(lambda match: convert(html.unescape(match[1])), content)
