"""Runs the commands of a chapter of the tutorial, its sh blocks, in an empty folder: tutorial.py SOURCE BUILD PAGE

The folder has links to the folders of the tree that the pages use. At the end every picture of a line "Picture: " must
exist as a PNG file that is not empty."""
import os
import re
import subprocess
import sys
import tempfile

SMALLEST = 3000  # bytes; an empty plot of gnuplot has less

source, build, page = (os.path.abspath(a) for a in sys.argv[1:])
with open(page, encoding="utf-8") as file:
    text = file.read()
blocks = re.findall(r"^```sh\n(.*?)^```$", text, re.DOTALL | re.MULTILINE)
pictures = [p for line in re.findall(r"^Picture: .*?(?=\n\n)", text, re.DOTALL | re.MULTILINE)
            for p in re.findall(r"`([^`]+\.(?:png|html))`", line)]
if not blocks or not pictures:
    sys.exit(f"{page}: no command or no picture")
with tempfile.TemporaryDirectory(prefix="quoin_tutorial_") as folder:
    for name in ("host", "plugin_api"):
        os.symlink(os.path.join(source, name), os.path.join(folder, name))
    path = os.pathsep.join([build, os.environ["PATH"]])
    done = subprocess.run(["bash", "-euo", "pipefail", "-c", "".join(blocks)], cwd=folder, env={**os.environ, "PATH": path})
    if done.returncode != 0:
        sys.exit(f"{page}: exit code {done.returncode}")
    for picture in pictures:
        with open(os.path.join(folder, picture), "rb") as file:
            content = file.read()
        if picture.endswith(".png") and (not content.startswith(b"\x89PNG") or len(content) < SMALLEST):
            sys.exit(f"{page}: {picture} is no picture")
