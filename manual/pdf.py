"""The manual as one PDF, from the pages of the HTML build: pdf.py HTML_FOLDER FILE.pdf. Exit code 1 on any warning.

Pages stand in the order of manual/index.md. Anchors get the name of their page, so that links lead where they do in HTML.
"""
import logging
import os
import re
import sys

import weasyprint

STYLE = """
@page { size: A4; margin: 22mm 18mm 20mm 18mm; @bottom-center { content: counter(page); font: 8pt sans-serif; } }
@page :first { @bottom-center { content: none; } }
body { font: 9.5pt/1.35 'DejaVu Serif', serif; }
h1, h2, h3, h4 { font-family: 'DejaVu Sans', sans-serif; line-height: 1.15; break-after: avoid; }
h1 { font-size: 17pt; } h2 { font-size: 12.5pt; } h3 { font-size: 10.5pt; } h4 { font-size: 9.5pt; }
article { break-before: page; }
a { color: #1a4a7a; text-decoration: none; }
code { font: 8.2pt 'DejaVu Sans Mono', monospace; overflow-wrap: break-word; }
pre { font: 7pt/1.3 'DejaVu Sans Mono', monospace; white-space: pre-wrap; overflow-wrap: break-word; background: #f4f4f2; padding: 2mm; }
table { border-collapse: collapse; width: 100%; font-size: 7.8pt; margin: 2mm 0; }
td, th { border-bottom: 0.2mm solid #bbb; padding: 0.7mm 1.4mm; text-align: left; vertical-align: top; overflow-wrap: break-word; }
td p, th p { margin: 0; } td code { font-size: 7pt; }
img { max-width: 100%; max-height: 130mm; }
nav p { font: bold 10pt 'DejaVu Sans', sans-serif; margin: 4mm 0 1mm; } nav ul { list-style: none; padding: 0; margin: 0; }
nav a::after { content: leader('.') target-counter(attr(href), page); }
nav ul ul { padding-left: 6mm; font-size: 8.5pt; }
.genindextable { font-size: 7.5pt; } .genindextable ul { list-style: none; padding: 0; margin: 0; }
.genindextable a::after { content: ', ' target-counter(attr(href), page); }
"""


class Warnings(logging.Handler):
    def __init__(self):
        super().__init__(logging.WARNING)
        self.texts = []

    def emit(self, record):
        self.texts.append(record.getMessage())


def body_of(path):
    with open(path, encoding="utf-8") as file:
        text = file.read()
    begin = text.index(">", text.index('class="body"')) + 1
    end = text.index('<div class="sphinxsidebar"', begin)
    # The four divisions that the theme closes behind the body.
    return re.sub(r"(\s*</div>|\s*<div class=\"clearer\"></div>){0,8}\s*$", "", text[begin:end])


def page_id(folder, path):
    return "page-" + re.sub(r"\W+", "-", os.path.relpath(path, folder)[:-len(".html")])


def without_marks(text):
    """A page without what shows in HTML alone: colours of code, links beside headings. Each would be a box of its own."""
    text = re.sub(r'<a class="headerlink"[^>]*>[^<]*</a>', "", text)
    text = re.sub(r'<span class="pre">([^<]*)</span>', r"\1", text)
    return re.sub(r"<pre>.*?</pre>", lambda code: re.sub(r"</?span[^>]*>", "", code[0]), text, flags=re.S)


def article(folder, path, known):
    """A page with its anchors and links as those of one document; pictures by their files."""
    own, here = page_id(folder, path), os.path.dirname(path)

    def link(found):
        target = found[1]
        if re.match(r"[a-z]+:", target):
            return found[0]
        file, _, fragment = target.partition("#")
        place = os.path.normpath(os.path.join(here, file)) if file else path
        if place not in known:
            return ""
        return f'href="#{page_id(folder, place)}{"--" + fragment if fragment else ""}"'

    text = without_marks(body_of(path))
    text = re.sub(r'\bid="([^"]*)"', lambda found: f'id="{own}--{found[1]}"', text)
    text = re.sub(r'\bhref="([^"]*)"', link, text)
    text = re.sub(r'\bsrc="([^"]*)"', lambda found: f'src="{os.path.normpath(os.path.join(here, found[1]))}"', text)
    return f'<article id="{own}">{text}</article>'


def contents(folder, index, pages):
    """The lists of the index, with the sections of each page."""
    out = []
    for caption, title, path in pages:
        if caption:
            out.append(f"<p>{caption}</p>")
        sections = re.findall(r'<section id="([^"]*)">\s*<h2>(.*?)<a class="headerlink"', body_of(path), re.S)
        inner = "".join(f'<li><a href="#{page_id(folder, path)}--{i}">{t}</a></li>' for i, t in sections)
        out.append(f'<ul><li><a href="#{page_id(folder, path)}">{title}</a><ul>{inner}</ul></li></ul>')
    return "<nav>" + "".join(out) + "</nav>"


def main():
    folder, target = os.path.abspath(sys.argv[1]), sys.argv[2]
    index = os.path.join(folder, "manual", "index.html")
    with open(index, encoding="utf-8") as file:
        text = file.read()
    pages, caption = [], ""
    for found in re.finditer(r'<span class="caption-text">(.*?)</span>|toctree-l1"><a[^>]*href="([^"#]*)">(.*?)</a>',
                             text[text.index("toctree-wrapper"):text.index("sphinxsidebar")]):
        if found[1]:
            caption = found[1]
        else:
            pages.append((caption, found[3], os.path.normpath(os.path.join(os.path.dirname(index), found[2]))))
            caption = ""
    pages.append(("Index", "Index", os.path.join(folder, "genindex.html")))
    known = {path for _, _, path in pages}
    warnings = Warnings()
    logger = logging.getLogger("weasyprint")
    logger.handlers = [warnings]
    book = (f"<html lang=\"en\"><head><title>Quoin: the manual</title></head><body><h1>Quoin: the manual</h1>"
            f"{contents(folder, index, pages)}{''.join(article(folder, path, known) for _, _, path in pages)}</body></html>")
    document = weasyprint.HTML(string=book, base_url=folder + "/").render(
        stylesheets=[weasyprint.CSS(string=STYLE)])
    document.write_pdf(target)
    for text in dict.fromkeys(warnings.texts):
        print(f"{target}: {text}", file=sys.stderr)
    print(f"{target}: {len(document.pages)} pages")
    return 1 if warnings.texts else 0


if __name__ == "__main__":
    sys.exit(main())
