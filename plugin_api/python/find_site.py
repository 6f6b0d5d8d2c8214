"""Prints the folder for modules of this Python under an installation prefix. Exit code 0 when the folder is on the default
search path. Usage: find_site.py PREFIX"""
import os
import site
import sys
import sysconfig

prefix = os.path.abspath(sys.argv[1])
# Without folders in /usr/local, which Debian adds for prefix /usr: /usr/local is another prefix.
searched = [folder for folder in site.getsitepackages()
            if folder.startswith(prefix + "/") and not folder.startswith(prefix + "/local/")]
print(searched[0] if searched else
      sysconfig.get_path("purelib", "posix_prefix", {"base": prefix, "platbase": prefix}))
sys.exit(not searched)
