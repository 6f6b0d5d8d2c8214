"""The gallery has a link to every shipped scene and study. Usage: gallery.py SOURCE"""
import glob
import os
import sys

source = os.path.abspath(sys.argv[1])
with open(os.path.join(source, "manual/GALLERY.md"), encoding="utf-8") as file:
    gallery = file.read()
shipped = [os.path.relpath(path, os.path.join(source, "manual"))
           for folder in ("scenes", "studies") for path in sorted(glob.glob(f"{source}/host/{folder}/*.toml"))]
absent = [path for path in shipped if f"]({path})" not in gallery]
print("\n".join(f"manual/GALLERY.md has no link to {path}" for path in absent) or f"{len(shipped)} scenes and studies in the gallery")
sys.exit(1 if absent or not shipped else 0)
