"""What MkDocs does beyond its own: the pages are plain Markdown that is also read in a repository browser, where links may
lead out of docs/. Pages outside docs/ that the navigation names join the site; other files that pages link to are copied
to `files/` as text, so that a browser shows them."""

import os
import pathlib
import posixpath
import re

from mkdocs.structure.files import File

ROOT = pathlib.Path(__file__).resolve().parents[2]
# The files of docs/ that are pages, pictures or examples; what makes the site is neither.
NOT_IN_SITE = re.compile(r"site/(?!site\.css$)")
LINK = re.compile(r"(?<!`)(!?\[[^\]\n]*(?:\n[^\]\n]*)?\]\()([^)\s]+)(\))")
CODE = re.compile(r"^(?: {4}|\t)[^\n]*$|^```.*?^```$|`[^`\n]+`", re.MULTILINE | re.DOTALL)


def slug(heading, separator="-"):
    """The anchor of a heading, as repository browsers make it."""
    return re.sub(r"[^\w\- ]", "", heading.strip().lower()).replace(" ", separator)


def on_config(config):
    config["mdx_configs"].setdefault("toc", {}).update(slugify=slug, permalink=True)
    return config


def site_pages(entry):
    """Every page that a part of the navigation names."""
    if isinstance(entry, str):
        return [entry]
    parts = entry.values() if isinstance(entry, dict) else entry
    return [page for part in parts for page in site_pages(part)]


def repository_path(source):
    """Path in the repository of a page that has `source` as its path in the site."""
    inside = pathlib.Path("docs") / source
    return inside.as_posix() if (ROOT / inside).exists() else source


def site_path(path, pages):
    """Path in the site of a file of the repository."""
    if path.startswith("docs/"):
        return path.removeprefix("docs/")
    return path if path in pages else f"files/{path}.txt"


def links(text):
    """The targets of relative links in a page's Markdown, code left out."""
    for match in LINK.finditer(CODE.sub("", text)):
        if not re.match(r"[a-z]+:|#", match[2]):
            yield match[2]


def on_files(files, config):
    for file in [file for file in files if NOT_IN_SITE.match(file.src_uri)]:
        files.remove(file)
    directory_urls = config["use_directory_urls"]
    outside = [page for page in site_pages(config["nav"]) if not (ROOT / "docs" / page).exists() and (ROOT / page).exists()]
    for page in outside:
        files.append(File(page, str(ROOT), config["site_dir"], directory_urls))
    config["extra"]["pages_outside"] = outside
    for page in list(files.documentation_pages()):
        source = repository_path(page.src_uri)
        for link in links((ROOT / source).read_text(encoding="utf-8")):
            target = posixpath.normpath(posixpath.join(posixpath.dirname(source), link.partition("#")[0]))
            place = site_path(target, outside)
            if place.startswith("files/") and place not in files and (ROOT / target).is_file():
                files.append(text_copy(target, place, config))
    return files


def text_copy(target, place, config):
    """A file of the repository, copied as text."""
    file = File(target, str(ROOT), config["site_dir"], False)
    file.src_uri = file.dest_uri = file.url = place
    file.abs_dest_path = os.path.join(config["site_dir"], place)
    return file


def on_page_markdown(markdown, page, config, files):
    source = repository_path(page.file.src_uri)
    outside = config["extra"]["pages_outside"]

    def replace(match):
        link, _, anchor = match[2].partition("#")
        if not link or re.match(r"[a-z]+:", link):
            return match[0]
        target = posixpath.normpath(posixpath.join(posixpath.dirname(source), link))
        if target == "include/bulkley":  # Doxygen makes these pages, after MkDocs: as HTML, which MkDocs does not check
            return f'<a href="api/index.html">{match[1][1:-2]}</a>'
        start = posixpath.dirname(page.file.src_uri) or "."
        place = posixpath.relpath(site_path(target, outside), start)
        return match[1] + place + ("#" + anchor if anchor else "") + match[3]

    # What tests are told stays as an empty comment, which keeps the blocks before and after it apart.
    markdown = re.sub(r"^ *<!-- test: .*?-->$", "<!-- -->", markdown, flags=re.MULTILINE | re.DOTALL)
    # What stands in code is no link.
    parts, end = [], 0
    for code in CODE.finditer(markdown):
        parts += [LINK.sub(replace, markdown[end:code.start()]), code[0]]
        end = code.end()
    return "".join(parts + [LINK.sub(replace, markdown[end:])])
