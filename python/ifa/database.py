"""Databases of random simulations, for the paper's contact-event graph (paper sections 4 and 5)."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np

from ifa import _core, arguments
from ifa._core import IfaValueError
from ifa.batch import sampling_options
from ifa.body import Body
from ifa.marks import MERGE_GAP_S
from ifa.simulation import Hits, Run, State

MOST_SIMULATIONS = 2**32 - 1


class Database:
    """The events of many random simulations of one body, as columns in memory-mapped files.

    Make one with `build`, or `open` one. A node is an event of a simulation, and its edge leads to
    the simulation's next event. `columns` maps names to read-only arrays of which row i is node i;
    they are the files themselves, and read from the disk as they are used:

    onset (n, 11) float64: just after the impact the event begins with, height, quaternion wxyz,
    velocity, angular velocity (world). take_off (n, 10) float32: just after the last contact, the
    world's up, velocity and spin in principal axes, and height. change (n, 6) float32: of velocity
    and spin over the event, in principal axes at take-off. delay_s, flight_s (n,) float32: from the
    onset to take-off, and from there to the next onset (0 where no flight leads there). energy_j
    (n,) float32: just before the last contact. amplitude (n,) float32, N s; length_s, centroid_s
    (n,) float32: of the event (CONVENTIONS.md, "Hits, events, rest"). simulation (n,) uint32; nodes
    of one follow one another. flags (n,) uint8: 1 the body comes to rest after it, 2 it has an
    edge to the next node, 4 something on the way there could be heard either way.

    `body`, `seed`, `events`, `merge_gap_s`, `sampling`, `until_s` and `simulations` say what it was
    built from. Orientations in `onset` are those of the body's principal axes. Trajectories are not
    stored: `replay` simulates an edge again.
    """

    __slots__ = ("_body", "_columns", "_core", "_graph", "_path")

    _body: Body
    _columns: Mapping[str, np.ndarray]
    _core: Any
    _graph: tuple[float, Any] | None  # the energy gain it is for, and the graph
    _path: Path

    def __init__(self) -> None:
        raise TypeError("make a Database with Database.build or Database.open")

    @classmethod
    def build(
        cls,
        body: Body,
        path: str | os.PathLike[str],
        simulations: int = 100_000,
        seed: int = 0,
        *,
        threads: int | None = None,
        events: str = "audible",
        sampling: Mapping[str, Any] | None = None,
        merge_gap_s: float = MERGE_GAP_S,
        until_s: float = 60.0,
        progress: _core.Progress | None = None,
    ) -> Database:
        """Simulate, and write the nodes into the folder `path`, which is made if need be.

        However it ends (also killed, or the disk full), the same call goes on where it stopped; a
        complete database is opened, or goes on to more simulations. The bytes are the same for any
        `threads` and interruptions.

        Args:
            body: What is simulated.
            path: A folder of its own. On the way it holds twice what it does in the end.
            simulations: How many, 1 or more. The first k are those of a smaller database.
            seed: Of the random states that they begin with, just before a contact.
            threads: 1 or more, None is one for each core.
            events: "audible" or "contact", as in `ifa.solve`.
            sampling: `cone_rad`, `speed_m_s`, `spin_rad_s` as in `ifa.sample_states`; what is left
                out is as there.
            merge_gap_s: Hits (of contact: flights) nearer than this belong to one event.
            until_s: A simulation ends there at the latest, at rest or not.
            progress: Read its `fraction`, call its `cancel()`; at `SIMULATED_SHARE` all is
                simulated.

        Raises:
            IfaValueError: naming the argument; also where `path` holds a database that was built
                from something else: the message says what differs.
            IfaFileError: naming the file that cannot be written or read.
            Cancelled: the same call goes on from there.
        """
        if not isinstance(body, Body):
            raise IfaValueError("body: needs an ifa.Body")
        if events not in ("audible", "contact"):
            raise IfaValueError(f'events: must be "audible" or "contact", got {events!r}')
        arguments.check_progress(progress)
        return cls._of(
            _core.build_database(
                body._core,
                _name(path),
                simulations=arguments.whole(simulations, "simulations", MOST_SIMULATIONS, least=1),
                seed=arguments.whole(seed, "seed", 2**64 - 1),
                threads=arguments.threads(threads),
                contact=events == "contact",
                merge_gap_s=arguments.positive(merge_gap_s, "merge_gap_s"),
                until_s=arguments.positive(until_s, "until_s"),
                progress=progress,
                **sampling_options(sampling),
            ),
            path,
        )

    @classmethod
    def open(cls, path: str | os.PathLike[str], body: Body | None = None) -> Database:
        """Open the database in the folder `path`, at once: `check` reads it all.

        Raises:
            IfaFileError: there is none, it is not complete, damaged or foreign; the message names
                the file.
            IfaValueError: it is of another body than `body`; the message says what differs.
        """
        if body is not None and not isinstance(body, Body):
            raise IfaValueError("body: needs an ifa.Body or None")
        database = cls._of(_core.open_database(_name(path)), path)
        if body is not None:
            database._core.need_body(body._core)
        return database

    @classmethod
    def _of(cls, core: Any, path: str | os.PathLike[str]) -> Database:
        database = object.__new__(cls)
        database._core = core
        database._graph = None
        database._path = Path(path)
        database._columns = MappingProxyType(core.columns)
        database._body = Body._of(core.body)
        return database

    @property
    def columns(self) -> Mapping[str, np.ndarray]:
        """Arrays by name; see the class."""
        return self._columns

    @property
    def nodes(self) -> int:
        """How many nodes it has, all simulations together."""
        return int(self._core.nodes)

    def __len__(self) -> int:
        """The number of nodes."""
        return self.nodes

    @property
    def simulations(self) -> int:
        """How many simulations it was built from."""
        return int(self._core.simulations)

    @property
    def body(self) -> Body:
        """The body that was simulated; what it looks like (mesh, notes) is not kept."""
        return self._body

    @property
    def seed(self) -> int:
        """The seed of the simulations."""
        return int(self._core.seed)

    @property
    def events(self) -> str:
        """What its events are: "audible" or "contact"."""
        return "contact" if self._core.contact else "audible"

    @property
    def merge_gap_s(self) -> float:
        """Hits (of contact: flights) nearer than this belong to one event."""
        return float(self._core.merge_gap_s)

    @property
    def until_s(self) -> float:
        """When a simulation ended at the latest."""
        return float(self._core.until_s)

    @property
    def sampling(self) -> dict[str, Any]:
        """How the simulations begin: `cone_rad`, `speed_m_s`, `spin_rad_s`."""
        return dict(self._core.sampling)

    @property
    def path(self) -> Path:
        """The folder."""
        return self._path

    def check(self, threads: int | None = None, progress: _core.Progress | None = None) -> None:
        """Read everything and compare it with its checksums; IfaFileError names a damaged file."""
        arguments.check_progress(progress)
        self._core.check(arguments.threads(threads), progress)

    def prepare(
        self, threads: int | None = None, progress: _core.Progress | None = None
    ) -> Database:
        """Make the transitions between its flights, which searches need, and keep them.

        Done once for a database, by the first solve at the latest; afterwards they are mapped from
        its folder. Where that cannot be written to they are made for this object alone. Returns the
        database.
        """
        arguments.check_progress(progress)
        self._graph_for(0.0, arguments.threads(threads), progress)
        return self

    @property
    def transitions(self) -> int:
        """How many transitions it has (paper section 5.2); makes them if need be."""
        return int(self._graph_for(0.0, 0, None).transitions)

    def _graph_for(self, gain_j: float, threads: int, progress: _core.Progress | None) -> Any:
        if self._graph is None or self._graph[0] != gain_j:
            self._graph = (gain_j, _core.make_graph(self._core, gain_j, threads, progress))
        return self._graph[1]

    def replay(self, node: int, progress: _core.Progress | None = None) -> Run:
        """Simulate again what comes after the onset of a node, until the next node's or to rest.

        The run begins just after the node's onset, at time 0 and x = y = 0, and ends just after the
        next one (status "time_limit") or at rest ("rest"). Its hits are those after the onset, the
        next one's included.

        Raises:
            IfaValueError: there is no such node, or nothing follows it.
            ReplayError: it does not lead to the stored next node, within 1e-6 of the body's size
                and speed: this is another processor or version of ifa.
        """
        arguments.check_progress(progress)
        which = arguments.whole(node, "node", max(self.nodes - 1, 0))
        rest_s, times_s, states, hits = self._core.replay(which, progress)
        status = "time_limit" if rest_s is None else "rest"
        return Run(status, times_s, State(*states), Hits(*hits), rest_s)

    def to_dict(self) -> dict[str, Any]:
        """What it is, as the command line prints it."""
        return {
            "path": str(self.path),
            "nodes": self.nodes,
            "terminal_nodes": int(np.count_nonzero(self.columns["flags"] & 1)),
            "bytes": sum(array.nbytes for array in self.columns.values()),
            "simulations": self.simulations,
            "seed": self.seed,
            "events": self.events,
            "merge_gap_s": self.merge_gap_s,
            "until_s": self.until_s,
            **self.sampling,
            "body": self.body.to_dict(),
            "version": _core.__version__,
        }

    def __repr__(self) -> str:
        return (
            f"<ifa.Database {str(self.path)!r}: {self.body.name}, {self.nodes} nodes of "
            f"{self.simulations} simulations>"
        )


def _name(path: Any) -> bytes:
    """The path as the core takes it: names of files need not be UTF-8."""
    try:
        name = os.fspath(path)
    except TypeError:
        raise IfaValueError(f"path: needs the name of a folder, got {path!r}") from None
    if not isinstance(name, str) or not name or "\0" in name:
        raise IfaValueError(f"path: needs the name of a folder, got {path!r}")
    return os.fsencode(name)
