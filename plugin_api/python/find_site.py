"""Where the Python that runs this finds modules that are installed under a prefix: prints the folder, with exit code 0 when
this Python looks there by itself. Usage: find_site.py PREFIX"""
import os
import site
import sys
import sysconfig

prefix = os.path.abspath(sys.argv[1])
# Not what Debian sends from /usr to /usr/local: /usr/local is a prefix of its own.
searched = [folder for folder in site.getsitepackages()
            if folder.startswith(prefix + "/") and not folder.startswith(prefix + "/local/")]
print(searched[0] if searched else
      sysconfig.get_path("purelib", "posix_prefix", {"base": prefix, "platbase": prefix}))
sys.exit(not searched)
