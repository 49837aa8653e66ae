"""The memory of the machine, as the system and its control groups tell it."""

import pytest

from parisph.base import memory


def write(root, **files):
    for name, text in files.items():
        path = root / name.replace("__", "/").replace("DOT", ".")
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)


def test_this_machine_has_some():
    assert 10**8 < memory.total() < 10**15


def test_without_control_groups_it_is_that_of_the_machine(tmp_path):
    assert memory.total(tmp_path) >= memory.total()


@pytest.mark.parametrize("files, limit", [
    ({"proc__self__cgroup": "0::/job/step\n", "sys__fs__cgroup__job__memoryDOTmax": "2000000\n",
      "sys__fs__cgroup__job__step__memoryDOTmax": "max\n"}, 2_000_000),
    ({"proc__self__cgroup": "0::/job\n", "sys__fs__cgroup__job__memoryDOTmax": "3000\n",
      "sys__fs__cgroup__memoryDOTmax": "1000\n"}, 1000),
    ({"proc__self__cgroup": "4:cpu,memory:/box\n1:name=x:/\n",
      "sys__fs__cgroup__memory__box__memoryDOTlimit_in_bytes": "5000\n"}, 5000),
    # in a container: the path is that of the host
    ({"proc__self__cgroup": "0::/host/path\n", "sys__fs__cgroup__memoryDOTmax": "7000\n"}, 7000),
])
def test_control_groups_limit_it(tmp_path, files, limit):
    write(tmp_path, **files)
    assert memory.total(tmp_path) == limit


def test_amounts_for_people():
    assert [memory.amount(n) for n in (0, 999, 223e6, 1.5e11, 2.5e15, 7.5e34)] == ["0 B", "999 B", "223 MB", "150 GB",
                                                                                   "2.5 PB", "7.5e+16 EB"]
