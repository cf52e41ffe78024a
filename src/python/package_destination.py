"""Prints where this Python looks for packages, below the prefix that they are installed to."""
import os
import site
import sys

# The first is the one for what is installed by hand; Debian's is below local/.
folder = site.getsitepackages()[0]
for prefix in os.path.join(sys.prefix, "local"), sys.prefix:
    if folder.startswith(prefix + "/"):
        print(os.path.relpath(folder, prefix))
        break
else:
    print("lib/python%d.%d/site-packages" % sys.version_info[:2])
