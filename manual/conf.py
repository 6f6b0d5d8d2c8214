"""The manual: pages that live beside the code, in one book. Built by the target `manual`; any link that leads nowhere is a
warning, and warnings are errors."""
import os

from docutils import nodes
from sphinx import addnodes

project, author, copyright = "Quoin", "the authors of Quoin", "the authors of Quoin"
extensions = ["myst_parser"]
root_doc = "manual/index"
source_suffix = {".md": "markdown"}
include_patterns = ["manual/*.md", "manual/tutorial/*.md", "manual/verification/*.md", "README.md", "CONTRIBUTING.md", "CHANGELOG.md", "host/*.md", "host/**/*.md", "plugin_api/*.md", "plugin_api/**/*.md", "contact_models/**/*.md",
                    "benchmarks/*.md", "tests/README.md", "tests/verification/README.md", "tests/cyclic_joint/README.md",
                    "tests/law/README.md"]
exclude_patterns = ["build"]
myst_heading_anchors = 4
html_theme = "alabaster"
html_theme_options = {"page_width": "1100px"}
# What a name is, by the heading of its table.
KINDS = {"Keys of scenes and studies": "key", "Columns of history.csv": "column", "Names of Python": "Python"}
ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))


def in_the_tree(app, env, node, content):
    """Links to folders of the tree: no page of this book, but no fault."""
    place = os.path.join(ROOT, os.path.dirname(node.get("refdoc", env.docname)), node["reftarget"])
    return content if os.path.isdir(place) else None


def title_of_tables(app, docname, source):
    """Tables that scripts write have no title; a book wants one."""
    if source[0].startswith("|"):
        source[0] = f"# {os.path.basename(docname).replace('_', ' ').capitalize()}\n\n{source[0]}"


def index_of_tables(app, doctree):
    """Entries of the index: keys, columns, options and names of Python in the reference, terms in the glossary."""
    page = app.env.docname
    if page not in ("manual/REFERENCE", "manual/GLOSSARY"):
        return
    for table in doctree.findall(nodes.tbody):
        heading = table.parent.parent.parent[0].astext()
        for row in table.findall(nodes.row):
            names = list(row.findall(nodes.literal)) if page == "manual/REFERENCE" else [row[0]]
            name = names[0].astext() if names else ""
            if not name:
                continue
            kind = KINDS.get(heading, "term") if heading != "Commands and options" else row[0].astext()
            target = nodes.make_id(f"index-{heading}-{row[0].astext()}-{name}")
            row[0].insert(0, addnodes.index(entries=[("single", f"{name} ({kind})", target, "", None)]))
            row[0].insert(1, nodes.target("", "", ids=[target]))
    app.env.get_domain("index").process_doc(app.env, page, doctree)  # once more, with the new entries


def setup(app):
    app.connect("doctree-read", index_of_tables)
    app.connect("source-read", title_of_tables)
    app.connect("missing-reference", in_the_tree)
    return {"env_version": 1}  # raised when pages are to be read again after a change here
