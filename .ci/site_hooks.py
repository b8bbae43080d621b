"""What mkdocs adds to the guide: the reference of the library, and the gallery of figures."""

from pathlib import Path

from mkdocs.structure.files import File

import camcli

FIGURES = Path(__file__).parents[1] / "out" / "figures"
BACK = '<header>\n<p><a href="../index.html">camcli: the guide</a></p>\n'  # from the gallery
SHOWN = ("*.html", "*/*.png", "*/*.gif", "*/*.html", "*/proof.json")


def on_config(config):
    """Without figures (`cam figures` draws them) there is no gallery."""
    if not (FIGURES / "index.html").is_file():
        config.nav = [entry for entry in config.nav if "Gallery" not in entry]
    return config


def on_page_markdown(markdown, page, config, files):
    """The front page leads to what only the site has."""
    if page.file.src_uri != "index.md":
        return markdown
    links = ["[the library](reference/library.md)"]
    if any("Gallery" in entry for entry in config.nav):
        links.append("[the gallery](gallery/index.html)")
    return f"{markdown}\n\nOn this site too: {' and '.join(links)}.\n"


def on_files(files, config):
    """Add the page of the library, and what `cam figures` wrote."""
    names = [name for name in camcli.__all__ if not name.startswith("_")]
    page = "# The library\n\n" + "\n".join(f"::: camcli.{name}\n" for name in names)
    files.append(File.generated(config, "reference/library.md", content=page))
    if (FIGURES / "index.html").is_file():
        for path in sorted(path for form in SHOWN for path in FIGURES.glob(form)):
            place = f"gallery/{path.relative_to(FIGURES)}"
            if place == "gallery/index.html":
                page = path.read_text(encoding="utf-8").replace("<header>\n", BACK, 1)
                files.append(File.generated(config, place, content=page))
                continue
            files.append(File.generated(config, place, abs_src_path=str(path)))
    return files
