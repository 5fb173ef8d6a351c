"""The Slurm of the tests itself: it runs jobs, survives the death of its node, and leaves nothing behind."""

import socket

import pytest
from slurm_cluster import Cluster, NoSlurmError, running_cluster, wait


def test_requeued_when_the_node_dies(slurm: Cluster) -> None:
    slurm.command("sbatch", "--requeue", "--job-name=dies", "--output=/dev/null", "--wrap=exec sleep 100")
    wait(slurm.processes)
    slurm.kill_node()
    wait(lambda: not slurm.processes())
    slurm.start_node()
    wait(lambda: slurm.command("squeue", "--noheader", "--name=dies", "--format=%T").split() == ["PENDING"])


def test_nothing_is_left() -> None:
    # The test above is skipped or fails where there is no Slurm; this second one has ports of its own.
    try:
        with running_cluster() as cluster:
            cluster.command("sbatch", "--output=/dev/null", "--wrap=trap '' TERM; sleep 100; sleep 100")
            wait(cluster.processes)
    except NoSlurmError:
        pytest.skip("see the other test")
    assert not cluster.processes()
    assert not cluster.folder.exists()
    for port in cluster.ports:
        with socket.socket() as one:
            assert one.connect_ex(("127.0.0.1", port)) != 0


@pytest.mark.parametrize(("ci", "ends"), [("", pytest.skip.Exception), ("true", pytest.fail.Exception)])
def test_continuous_integration_does_not_skip(ci: str, ends: type, monkeypatch: pytest.MonkeyPatch) -> None:
    from conftest import no_slurm

    monkeypatch.setenv("CI", ci)
    with pytest.raises(ends, match="no slurmctld"):
        no_slurm(NoSlurmError("there is no slurmctld"))
