"""A hook of MkDocs: a page's path in backticks, `docs/how_to/x.md`, becomes a link to the page."""
import os
import re

PAGE = re.compile(r"`docs/([a-z_/]+\.md)`")


def on_page_markdown(markdown, page, config, files):
    here = os.path.dirname(page.file.src_uri)
    known = {file.src_uri for file in files}

    def link(match):
        target = match.group(1)
        if target not in known:
            return match.group(0)
        title = target.rsplit("/", 1)[-1][:-3].replace("_", " ")
        return f"[{title}]({os.path.relpath(target, here or '.')})"

    blocks = re.split(r"(^```.*?^```$)", markdown, flags=re.S | re.M)  # code stays as it is
    return "".join(block if block.startswith("```") else PAGE.sub(link, block) for block in blocks)
