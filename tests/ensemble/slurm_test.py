"""A study computed by Slurm, on a cluster of one node, which this test starts and ends. Usage: slurm_test.py QUOIN STUDY

The table is equal, byte for byte, to that of a study without Slurm, also when slurmd is killed in the middle. Exit code 77,
with the reason: skipped.
"""
import atexit
import os
import pathlib
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import time

quoin, study = sys.argv[1:]
SAMPLES = "30"


def skip(why):
    print(f"skipped: {why}")
    sys.exit(77)


def free_port():
    with socket.socket() as s:
        s.bind(("127.0.0.1", 0))
        return s.getsockname()[1]


os.environ["PATH"] += ":/usr/sbin:/usr/bin"
if os.geteuid() != 0:
    skip("slurmd and munged are started as root only")
folder = pathlib.Path(tempfile.mkdtemp(prefix="quoin_slurm_"))
folder.chmod(0o755)
node = socket.gethostname().split(".")[0]
daemons = {}


def start(name, words):
    log = open(folder / f"{name}.log", "a")
    daemons[name] = subprocess.Popen(words, stdout=log, stderr=log, start_new_session=True)
    return daemons[name]


def end():
    for process in daemons.values():
        if process.poll() is None:
            process.send_signal(signal.SIGTERM)
    for process in daemons.values():
        try:
            process.wait(10)
        except subprocess.TimeoutExpired:
            process.kill()
    shutil.rmtree(folder, ignore_errors=True)


atexit.register(end)


def wait_for(what, holds, seconds=60):
    for _ in range(seconds * 10):
        if holds():
            return
        time.sleep(0.1)
    logs = "".join(f"--- {f.name}\n{f.read_text(errors='replace')[-1500:]}" for f in folder.glob("*.log"))
    skip(f"{what} did not come up here:\n{logs}")


# The key of this cluster, and its daemons.
(folder / "munge.key").write_bytes(os.urandom(1024))
(folder / "munge.key").chmod(0o400)
for name in ("state", "spool"):
    (folder / name).mkdir()
sock = folder / "munge.socket"
start("munged", ["munged", "--foreground", "--force", f"--socket={sock}", f"--key-file={folder}/munge.key",
                 f"--pid-file={folder}/munged.pid", f"--log-file={folder}/munged.own.log", f"--seed-file={folder}/munged.seed"])
wait_for("munged", sock.exists, 10)
conf = folder / "slurm.conf"
conf.write_text(f"""ClusterName=quoin
SlurmctldHost={node}(127.0.0.1)
SlurmUser=root
AuthType=auth/munge
AuthInfo=socket={sock}
CredType=cred/munge
SlurmctldPort={free_port()}
SlurmdPort={free_port()}
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
SwitchType=switch/none
MpiDefault=none
ReturnToService=2
SlurmdTimeout=5
BatchStartTimeout=1
KillWait=1
SchedulerParameters=sched_interval=1,batch_sched_delay=0
SlurmdParameters=config_overrides
NodeName={node} NodeAddr=127.0.0.1 CPUs=2 State=UNKNOWN
PartitionName=all Nodes={node} Default=YES MaxTime=INFINITE State=UP
""")
os.environ["SLURM_CONF"] = str(conf)
start("slurmctld", ["slurmctld", "-D", "-f", str(conf)])
slurmd = ["slurmd", "-D", "-N", node, "-f", str(conf)]
start("slurmd", slurmd)


def node_state():
    return subprocess.run(["sinfo", "-h", "-o", "%T"], capture_output=True, text=True).stdout.strip()


wait_for("the node of Slurm", lambda: node_state() in ("idle", "mixed", "allocated"))


def ensemble(out, *more):
    words = [quoin, "ensemble", study, "--out", str(folder / out), "--samples", SAMPLES, "--no-pictures", *more]
    return subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


def finish(process, out):
    told = process.communicate(timeout=200)
    logs = "".join(f.read_text(errors="replace") for f in (folder / out).glob("slurm-*.log"))
    if process.returncode != 0:
        sys.exit(f"{out}: exit code {process.returncode}: {told}\n{logs}")
    return (folder / out / "samples.csv").read_bytes(), told[1]


def finished(out):
    return len(list((folder / out / "samples").glob("*/sample.json")))


alone, _ = finish(ensemble("alone", "--jobs", "2"), "alone")
by_slurm, told = finish(ensemble("slurm", "--slurm", "--tasks", "4"), "slurm")
if "job 1 of Slurm: 4 workers" not in told:
    sys.exit(f"not told what was submitted: {told}")
if not list((folder / "slurm").glob("slurm-*.log")):
    sys.exit("the tasks of Slurm left no logs: who computed the samples?")
if by_slurm != alone:
    sys.exit("the table of the study by Slurm is another one")

# slurmd and its tasks are killed in the middle; after its restart the remaining samples are computed.
process = ensemble("killed", "--slurm", "--tasks", "4")
for _ in range(600):
    if finished("killed") >= 3:
        break
    time.sleep(0.05)
daemons["slurmd"].kill()
for word in ("slurmstepd", quoin):  # processes that it has started on this node for this study
    for entry in pathlib.Path("/proc").glob("[0-9]*"):
        try:
            line = (entry / "cmdline").read_bytes()
            mine = str(folder).encode() in line + (entry / "environ").read_bytes()
            if word.encode() in line and mine and int(entry.name) != process.pid:
                os.kill(int(entry.name), signal.SIGKILL)
        except OSError:
            pass
kept = finished("killed")
# The node is down; its tasks are requeued, and run when the node is up again.
for _ in range(900):
    if node_state().startswith("down"):
        break
    time.sleep(0.1)
start("slurmd", slurmd)
table, _ = finish(process, "killed")
if table != alone:
    sys.exit(f"slurmd killed after {kept} samples: the table is another one")
print(f"30 samples by Slurm; slurmd killed after {kept} of 31: the same table")
