"""Builds the wheel of quoin for pip (pyproject.toml): CMake compiles, and a wheel is a zip file with three texts. It
requires no Python package, so that it works in an empty environment without network. $QUOIN_CMAKE_ARGS: additional
arguments of CMake; $CMAKE_BUILD_PARALLEL_LEVEL: number of compilers at the same time. Missing tools are reported before
any compilation: pip requests the metadata first, and installs NumPy before it requests the wheel."""
import base64
import hashlib
import os
import re
import shlex
import shutil
import subprocess
import sys
import sysconfig
import zipfile

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
# One folder for each Python version, with its own module, and the laws. It is kept, so that another `pip install .`
# compiles changes alone.
BUILD = os.path.join(ROOT, "build", f"pip-{sys.implementation.cache_tag}")
SUFFIX = sysconfig.get_config_var("EXT_SUFFIX")


def version():
    with open(os.path.join(ROOT, "CMakeLists.txt"), encoding="utf-8") as file:
        return re.search(r"project\(quoin VERSION (\S+)", file.read())[1]


def configure():
    """Finds all tools of the build, or exits with a list of missing ones."""
    if not shutil.which("cmake"):
        raise SystemExit("quoin: not built: cmake is not installed; scripts/setup.sh lists what the build needs")
    # In a virtual environment CMake needs the interpreter of pip, whose headers are in its base.
    if subprocess.run(["cmake", "-S", ROOT, "-B", BUILD, "-DCMAKE_BUILD_TYPE=Release", f"-DQUOIN_PYTHON={sys.executable}",
                       "-DQUOIN_PYTHON_REQUIRED=ON", "-DQUOIN_BUILD_TESTS=OFF", "-DQUOIN_BUILD_ADAPTERS=OFF",
                       *shlex.split(os.environ.get("QUOIN_CMAKE_ARGS", ""))]).returncode != 0:
        raise SystemExit("quoin: not built: something is missing (see the lines above); the Python package needs "
                         "pybind11-dev, python3-dev and what scripts/setup.sh lists")


def side_by_side():
    """Number of compilers at the same time: one per available core, with 1.5 GB of free memory each."""
    cores = len(os.sched_getaffinity(0))
    try:
        with open("/proc/meminfo", encoding="utf-8") as file:
            free = int(re.search(r"MemAvailable:\s+(\d+) kB", file.read())[1])
    except (OSError, TypeError):
        return cores
    return max(1, min(cores, free // 1500000))


def compile_package():
    configure()
    jobs = os.environ.get("CMAKE_BUILD_PARALLEL_LEVEL") or str(side_by_side())
    if subprocess.run(["cmake", "--build", BUILD, "--parallel", jobs, "--target", "quoin_python"]).returncode != 0:
        raise SystemExit("quoin: not built (see the lines above)")


def metadata():
    return (f"Metadata-Version: 2.1\nName: quoin\nVersion: {version()}\nSummary: Contact laws for discrete-element masonry, "
            "and a small, fast host that proves them\nRequires-Python: >=3.9\nRequires-Dist: numpy\n")


def prepare_metadata_for_build_wheel(metadata_directory, config_settings=None):
    configure()
    info = f"quoin-{version()}.dist-info"
    os.mkdir(os.path.join(metadata_directory, info))
    with open(os.path.join(metadata_directory, info, "METADATA"), "w", encoding="utf-8") as file:
        file.write(metadata())
    return info


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):
    compile_package()
    tag = f"{sys.implementation.cache_tag.replace('cpython-', 'cp')}"
    tag = f"{tag}-{tag}-{sysconfig.get_platform().replace('-', '_').replace('.', '_')}"
    info = f"quoin-{version()}.dist-info"
    files = {}
    package = os.path.join(BUILD, "python", "quoin")
    for name in sorted(os.listdir(package)):
        if name.endswith((".py", SUFFIX)):
            with open(os.path.join(package, name), "rb") as file:
                files[f"quoin/{name}"] = file.read()
    with open(os.path.join(BUILD, "laws.txt"), encoding="utf-8") as laws:
        for law in laws.read().split():
            with open(os.path.join(BUILD, "laws", law + ".so"), "rb") as file:
                files[f"quoin/laws/{law}.so"] = file.read()
    files["quoin/where.txt"] = b"laws\n"
    files[f"{info}/METADATA"] = metadata().encode()
    files[f"{info}/WHEEL"] = f"Wheel-Version: 1.0\nGenerator: quoin\nRoot-Is-Purelib: false\nTag: {tag}\n".encode()
    record = f"{info}/RECORD"
    lines = [f"{name},sha256={base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b'=').decode()},{len(data)}"
             for name, data in files.items()]
    files[record] = ("\n".join(lines) + f"\n{record},,\n").encode()
    wheel = f"quoin-{version()}-{tag}.whl"
    with zipfile.ZipFile(os.path.join(wheel_directory, wheel), "w", zipfile.ZIP_DEFLATED) as archive:
        for name, data in files.items():
            archive.writestr(name, data)
    return wheel


def build_sdist(sdist_directory, config_settings=None):
    raise SystemExit("quoin: no source distribution; install from the repository")
