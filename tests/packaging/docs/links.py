#!/usr/bin/env python3
"""Every link leads somewhere: in the Markdown pages, as a repository browser reads them, and, with --site FOLDER, in the
HTML of the site. Files exist, anchors exist, addresses outside are well formed (no network is asked), and no page of the
site loads anything from elsewhere. Prints a line for each fault and exits 1 if there is any."""

import argparse
import html
import pathlib
import re
import sys
import urllib.parse

sys.dont_write_bytecode = True
ROOT = pathlib.Path(__file__).resolve().parents[3]
sys.path.insert(0, str(ROOT / "tests/packaging/docs"))
from blocks import FENCE  # noqa: E402

LINK = re.compile(r"!?\[(?:[^\]\n]|\n(?!\n))*\]\(\s*([^)\s]+)\s*\)")
HEADING = re.compile(r"^#{1,6} +(.*?)(?: +#+)?$")
# In HTML: what a page refers to, what may be referred to, and what a browser loads with a page.
REFERENCE = re.compile(r'<(\w+)\b[^>]*?\b(?:href|src)="([^"]*)"')
ANCHOR = re.compile(r'<[^>]*?\b(?:id|name)="([^"]*)"')
LOADED = {"script", "link", "img", "iframe", "source", "video"}


def pages():
    return [ROOT / "README.md", ROOT / "CHANGELOG.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").rglob("*.md")),
            *sorted((ROOT / "tests").rglob("README.md"))]


def prose(text):
    """Markdown with its code blanked out, line by line."""
    lines, fence, before = [], None, ""
    for line in text.splitlines():
        mark = FENCE.match(line)
        if fence or mark:
            fence = (mark[2] if not fence else (None if line.strip() == fence else fence))
            line = ""
        elif line.startswith("    ") and not before.strip():
            lines.append("")
            continue  # `before` stays empty: the block goes on
        lines.append(re.sub(r"`[^`]*`", lambda code: "x" * len(code[0]), line))
        before = line
    return "\n".join(lines)


def slug(heading):
    """The anchor that repository browsers make of a heading."""
    text = re.sub(r"!?\[([^\]]*)\]\([^)]*\)", r"\1", heading)
    return re.sub(r"[^\w\- ]", "", text.strip().lower()).replace(" ", "-")


def anchors(path):
    found = {}
    in_fence = False
    for line in path.read_text(encoding="utf-8").splitlines():
        if FENCE.match(line):
            in_fence = not in_fence
        heading = HEADING.match(line)
        if heading and not in_fence:
            name = slug(heading[1])
            found[name] = found.get(name, -1) + 1
    return {name if n == 0 else f"{name}-{n}" for name, last in found.items() for n in range(last + 1)}


def address_fault(address):
    try:
        parts = urllib.parse.urlsplit(address)
    except ValueError as error:
        return str(error)
    if parts.scheme == "mailto":
        return None if re.fullmatch(r"[^@\s]+@[^@\s]+\.\w+", parts.path) else "this is no mail address"
    if parts.scheme not in ("http", "https"):
        return f"the scheme '{parts.scheme}' is neither http nor https"
    return None if re.fullmatch(r"[\w.-]+\.\w+(:\d+)?", parts.netloc) else f"'{parts.netloc}' is no host"


def markdown_faults(n_links):
    known = {}
    for page in pages():
        text = prose(page.read_text(encoding="utf-8"))
        for match in LINK.finditer(text):
            n_links[0] += 1
            place = f"{page.relative_to(ROOT)}:{text.count(chr(10), 0, match.start()) + 1}"
            link = match[1]
            if re.match(r"[a-z]+:", link):
                fault = address_fault(link)
            else:
                name, _, anchor = link.partition("#")
                target = (page.parent / urllib.parse.unquote(name)).resolve() if name else page
                fault = None
                if not target.exists():
                    fault = "there is no such file"
                elif ROOT not in (target, *target.parents):
                    fault = "leads out of the repository"
                elif anchor:
                    if target not in known:
                        known[target] = anchors(target) if target.suffix == ".md" else set()
                    fault = None if anchor in known[target] else f"{target.relative_to(ROOT)} has no heading for this anchor"
            if fault:
                yield f"{place}: {link}: {fault}"


def site_faults(site, n_links):
    files = sorted(site.rglob("*.html"))
    texts = {path: path.read_text(encoding="utf-8", errors="replace") for path in files}
    ids = {path: {html.unescape(name) for name in ANCHOR.findall(text)} for path, text in texts.items()}
    for path, text in texts.items():
        seen = set()
        for tag, raw in REFERENCE.findall(text):
            link = html.unescape(raw)
            if (tag, link) in seen or link.startswith(("javascript:", "data:")):
                continue
            seen.add((tag, link))
            n_links[0] += 1
            fault = site_fault(tag, link, path, site, ids)
            if fault:
                yield f"{path.relative_to(site)}: {link}: {fault}"
    for path in sorted(site.rglob("*.css")):
        for address in re.findall(r"url\(['\"]?(https?:[^)'\"]+)", path.read_text(encoding="utf-8", errors="replace")):
            yield f"{path.relative_to(site)}: {address}: is loaded from elsewhere"


def site_fault(tag, link, path, site, ids):
    """What is wrong with a link of the page `path`; None: nothing."""
    if re.match(r"[a-z]+:|//", link):
        return "is loaded from elsewhere" if tag in LOADED else address_fault(link)
    name, _, anchor = link.partition("#")
    name = urllib.parse.unquote(name.partition("?")[0])
    if name.startswith("/"):
        return "begins at the root of a server"
    target = (path.parent / name).resolve() if name else path
    if not target.is_file():
        return "there is no such file"
    if site not in target.parents:
        return "leads out of the site"
    anchor = urllib.parse.unquote(anchor)
    if anchor and target in ids and anchor not in ids[target]:
        return "there is no such anchor"
    return None


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--site", type=pathlib.Path, help="folder that cluster/docs.sh has made")
    arguments = parser.parse_args()
    n_links = [0]
    faults = list(markdown_faults(n_links))
    summary = f"{n_links[0]} links in Markdown"
    if arguments.site:
        n_site = [0]
        site = arguments.site.resolve()
        if not (site / "index.html").is_file():
            sys.exit(f"FAILED: {site} holds no site")
        faults += site_faults(site, n_site)
        summary += f", {n_site[0]} in the pages of the site"
    print(summary)
    if faults:
        sys.exit("\n".join(faults))


if __name__ == "__main__":
    main()
