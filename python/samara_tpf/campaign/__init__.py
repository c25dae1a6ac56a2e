"""Campaigns on a cluster: ``python -m samara_tpf.campaign MISSION --trials 1e8 --cluster slurm``.

A campaign is cut into shards. Dask's workers fly them, each by ``samara assess --shard I/N`` as a child process in a
folder of the worker's own, and give back the file's bytes; the driver alone writes them to ``DIR/shards``, whole or
not at all, and ends with ``samara merge DIR``. What is there is not flown again, whoever was killed before: the
driver, its scheduler, a worker, a machine. ``--study KIND`` sends the jobs of a study the same way, round by round,
and ``--search design`` or ``--search tune`` those of a search. Needs the program ``samara`` and Dask, not the extension
module.

========== ========================================================================
module     holds
========== ========================================================================
arguments  what can be typed
order      what is asked of workers: shards of a campaign, or of a round of a study
child      a command run to its end, unless nobody wants it any more
program    the program ``samara``; what campaign its arguments make
work       what a worker does: it checks itself, and makes a shard
roster     which shard goes to which worker, without Dask and without a clock
folder     the folder of results: what is there, what is left, one driver at a time
instances  numbers of the PX4s on each host
manifests  what Kubernetes is given
clusters   where workers come from: this machine, Slurm, Kubernetes, an address
progress   how far it is, on the terminal
flight     the roster's decisions carried out by Dask, one order after another
study      a study or a search in rounds, whose jobs the workers fly
driver     the whole, from the arguments to the exit code
========== ========================================================================
"""
