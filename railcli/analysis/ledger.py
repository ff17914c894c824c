"""Where the energy of a run went: kinetic energies at both ends, and what the core booked (docs/subsystems.md, 7)."""

from dataclasses import dataclass

import numpy as np

LOSSES = {  # field of TRAIN, what took it
    "creep_loss": "creep, spin included",
    "brake_loss": "brakes",
    "suspension_loss": "suspension: dampers, friction, stored",
    "normal_loss": "normal contact and track: damped, stored",
    "resistance_loss": "running resistance",
}
GAINS = {"gravity_work": "weights", "traction_work": "traction", "holding_work": "force that holds the speed"}


@dataclass(frozen=True)
class Ledger:
    """Energies of a run [J].

    Attributes
    ----------
    start, end : float
        Kinetic energy, that of rotation included.
    gains, losses : dict of str to float
        Keys of GAINS and LOSSES.
    """

    start: float
    end: float
    gains: dict
    losses: dict

    @property
    def unbooked(self):
        """What nobody took: start and gains less losses and end [J]."""
        return self.start + sum(self.gains.values()) - sum(self.losses.values()) - self.end

    @property
    def whole(self):
        """The largest of the kinetic energies and of all gains together [J]."""
        return max(self.start, self.end, sum(map(abs, self.gains.values())), 1e-300)

    @property
    def share(self):
        """`unbooked` over `whole` [-]."""
        return self.unbooked / self.whole


def kinetic_energy(model, data):
    """Of all bodies, with their rotation [J]."""
    body, v = model.body, data.v
    return 0.5 * float(
        np.sum(body["mass"] * (v[:, :3] ** 2).sum(axis=1)) + np.sum(body["inertia"] * v[:, 3:] ** 2)
    )


def ledger(system, first, last):
    """Ledger of a run of a system with subsystems; first, last : Data at its ends."""
    before, after = first.train[0], last.train[0]
    booked = {key: float(after[key] - before[key]) for key in (*GAINS, *LOSSES)}
    return Ledger(
        kinetic_energy(system.model, first),
        kinetic_energy(system.model, last),
        {key: booked[key] for key in GAINS},
        {key: booked[key] for key in LOSSES},
    )
