"""The manual: pages that live beside the code, in one book. Built by the target `manual`; any link that leads nowhere is a
warning, and warnings are errors."""
import os

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
ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))


def in_the_tree(app, env, node, content):
    """Links to folders of the tree: no page of this book, but no fault."""
    place = os.path.join(ROOT, os.path.dirname(node.get("refdoc", env.docname)), node["reftarget"])
    return content if os.path.isdir(place) else None


def title_of_tables(app, docname, source):
    """Tables that scripts write have no title; a book wants one."""
    if source[0].startswith("|"):
        source[0] = f"# {os.path.basename(docname).replace('_', ' ').capitalize()}\n\n{source[0]}"


def setup(app):
    app.connect("source-read", title_of_tables)
    app.connect("missing-reference", in_the_tree)
