"""A run as a moving picture: the vehicle from above and from behind, its displacements magnified, and its contacts.

Seen in track axes: the track is drawn straight, every body where it stands against the track at its own centre. Small
rotations turn a body's points by their magnified angle times their distance, like the linear motion they are.
"""

import io
from dataclasses import dataclass

import numpy as np
from matplotlib import rc_context
from matplotlib.animation import FFMpegWriter
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from railcli.analysis.rigid_contact import wheelset_on
from railcli.errors import InputError
from railcli.files.embed import uri_of
from railcli.files.output import whole_file
from railcli.files.profiles import profile_of
from railcli.model.system import table_settings

from .figures import BLUE, GREEN, GREY, ORANGE, STYLE, VERMILION, any_letter, fonts, words
from .vehicle_shapes import chain, shapes
from .wheelset import outlines

KINDS = ("page", "gif", "mp4")
RATE = 20  # frames per second
SIZE, DPI = (11.0, 7.6), 80
COLOURS = 192  # of all frames
SHOWN = 0.7  # largest displacement in the picture [m]
TURNED = 0.2  # largest roll in the picture [rad]
STEPS = (1.0, 2.0, 5.0)  # of the magnification, times powers of ten
LARGEST = 1000.0  # magnification
BODY_COLOURS = {"wheelset": "black", "bogie": ORANGE, "body": BLUE}
SIDES = (("right", 1.0, BLUE), ("left", -1.0, VERMILION))
DOT = 90.0  # area of a contact point that bears 100 kN [points^2]
FORCE = 0.4  # length of a force [mm per kN]
CLOSE = ((-60.0, 60.0), (-45.0, 40.0))  # what a close-up shows: across from the tape circle, down [mm]
PIECE = 20_000  # rows in memory


@dataclass(frozen=True)
class Frames:
    """Some instants of a run; SI, track axes.

    Attributes
    ----------
    time, s : array (n,)
        s: arc length of the first body.
    position, rotation : dict of str to array (n, 3)
        By body.
    normal, on_wheel, angle : dict of str to array (n, n_patch)
        By wheel.
    """

    time: np.ndarray
    s: np.ndarray
    position: dict
    rotation: dict
    normal: dict
    on_wheel: dict
    angle: dict


def frames(results, count):
    """Instants evenly over all rows.

    Parameters
    ----------
    results : Results
    count : int
        At most so many.
    """
    rows = np.unique(np.linspace(0, results.rows - 1, count).round().astype(int))
    bodies = [f"bodies/{name}/{channel}" for channel in ("position", "rotation") for name in results.bodies]
    patches = [
        f"wheels/{name}/contact/{channel}" for channel in ("normal", "on_wheel", "angle") for name in results.wheels
    ]
    names, kept, start = ["time", *bodies, *patches], [], 0
    for values in results.pieces(*names, size=PIECE):
        inside = rows[(rows >= start) & (rows < start + values[0].size)] - start
        kept.append([array[inside] for array in values])
        start += values[0].size
    time, *arrays = (np.concatenate(parts) for parts in zip(*kept, strict=True))
    arrays = iter(arrays)
    position, rotation = ({name: next(arrays) for name in results.bodies} for _ in range(2))
    normal, on_wheel, angle = ({name: next(arrays) for name in results.wheels} for _ in range(3))
    return Frames(time, position[results.bodies[0]][:, 0], position, rotation, normal, on_wheel, angle)


def magnifications(shown):
    """From above and from behind: 1, 2 or 5 times a power of ten, as large as leaves the picture readable.

    The largest lateral or vertical displacement of a body becomes at most SHOWN, seen from behind also its roll TURNED.
    """
    moves = max(np.abs([place[:, 1], place[:, 2] - place[0, 2]]).max() for place in shown.position.values())
    rolls = max(np.abs(turn[:, 0]).max() for turn in shown.rotation.values())
    above = _round_down(SHOWN / max(moves, SHOWN / LARGEST))
    return above, min(above, _round_down(TURNED / max(rolls, TURNED / LARGEST)))


def _round_down(value):
    value = max(value, 1.0) * (1.0 + 1e-9)
    scale = 10.0 ** np.floor(np.log10(value))
    return float(scale * max(step for step in STEPS if step * scale <= value))


class Film:
    """The moving picture of one result.

    Parameters
    ----------
    one : Curves
        Its scenario must be readable.
    count : int
        Frames at most.
    magnify : float, optional
        Of displacements and rotations; by default chosen by their size.
    wheelset : int
        Whose wheels are seen from behind and from near, from 1 on.

    Attributes
    ----------
    figure : matplotlib.figure.Figure
    magnify : (float, float)
        From above, from behind.
    """

    def __init__(self, one, count, magnify=None, wheelset=1):
        scenario = one.results.scenario
        self._one, self._vehicle = one, scenario.vehicle
        self._lateral = scenario.contact.tape_circle
        self._shapes = shapes(scenario.vehicle, self._lateral)
        self._wheelset = wheelset - 1
        self._name = one.results.wheelsets[wheelset - 1]
        self._shown = frames(one.results, count)
        self.magnify = magnifications(self._shown) if magnify is None else (magnify, magnify)
        self._mountings = self._profiles(scenario)
        self._pace = (self._shown.time[-1] - self._shown.time[0]) / max(1, len(self) - 1) * RATE
        with rc_context({**STYLE, "font.family": fonts()}), any_letter():
            self._build()
            words(self.figure)

    def __len__(self):
        return self._shown.time.size

    @property
    def caption(self):
        """What the picture shows, in sentences."""
        above, behind = self.magnify
        return (
            f"Displacements and rotations {above:g} times (from above) and {behind:g} times (from behind) as large as "
            "they are, against the track, which is drawn straight; bodies as boxes, each at its own centre; heights "
            "against those at the start. Dots are contact points, larger the more they bear. From near, true to "
            f"scale: the wheels of W{self._wheelset + 1} on their rails in their nominal places, with the normal "
            f"forces on the wheel. {len(self)} frames, {self._pace:.3g} times as fast as it was."
        )

    def write(self, path, kind, progress=lambda done: None):
        """Write it as a GIF or MP4 file, whole or not at all."""
        with whole_file(path) as temporary:
            if kind == "gif":
                first, *rest = self._images(progress)
                first.save(temporary, format="GIF", save_all=True, append_images=rest, duration=1000 // RATE, loop=0)
            else:
                writer = FFMpegWriter(fps=RATE, codec="h264", extra_args=["-pix_fmt", "yuv420p"])
                for artist in self._moving:
                    artist.set_animated(False)
                with writer.saving(self.figure, temporary, DPI):
                    for k in range(len(self)):
                        self.show(k)
                        writer.grab_frame()
                        progress(k + 1)

    def data_uris(self, progress=lambda done: None):
        """Every frame as the data URI of a PNG picture."""
        found = []
        for image in self._images(progress):
            file = io.BytesIO()
            image.save(file, format="PNG")
            found.append(uri_of(file.getvalue(), ".png"))
        return found

    def _images(self, progress):
        from PIL import Image

        canvas = self.figure.canvas
        canvas.draw()
        still = canvas.copy_from_bbox(self.figure.bbox)
        for k in range(len(self)):
            canvas.restore_region(still)
            self.show(k)
            for artist in self._moving:
                artist.axes.draw_artist(artist)
            frame = Image.fromarray(np.asarray(canvas.buffer_rgba())[:, :, :3].copy())
            if k == 0:  # every colour is in the first frame
                palette = frame.quantize(COLOURS, method=Image.Quantize.MAXCOVERAGE, dither=Image.Dither.NONE)
            yield frame.quantize(palette=palette, dither=Image.Dither.NONE)
            progress(k + 1)

    def _profiles(self, scenario):
        """Mounted right and left wheel; None, with a note, when a profile is not to be found any more."""
        contact = scenario.contact
        body = self._vehicle.bodies[self._vehicle.wheelsets[self._wheelset]]
        try:
            wheel = profile_of(scenario, contact.wheel_profile, "wheel")
            rail = profile_of(scenario, contact.rail_profile, "rail")
        except InputError as error:
            self._one.notes.append(f"animation without profiles: {error}")
            return None
        return wheelset_on(table_settings(scenario, body.wheel_radius), wheel, rail).mountings

    def _build(self):
        self.figure = Figure(figsize=SIZE, dpi=DPI, layout="constrained")
        FigureCanvasAgg(self.figure)
        grid = self.figure.add_gridspec(3, 3, height_ratios=(1.0, 1.6, 0.45), width_ratios=(0.95, 1.0, 1.0))
        self._moving, self._updates = [], []
        self._from_above(self.figure.add_subplot(grid[0, :]))
        self._from_behind(self.figure.add_subplot(grid[1, 0]))
        for column, (side, sign, colour) in zip((2, 1), SIDES, strict=True):
            self._from_near(self.figure.add_subplot(grid[1, column]), side, sign, colour)
        self._along(self.figure.add_subplot(grid[2, :]))
        self.show(0)
        self.figure.canvas.draw()
        self.figure.set_layout_engine("none")

    def show(self, k):
        """Put everything where it is in frame k."""
        for update in self._updates:
            update(k)

    def _add(self, artist, update):
        artist.set_animated(True)
        self._moving.append(artist)
        self._updates.append(lambda k: update(artist, k))

    def _body(self, axis, name, outline, place):
        """A box that is filled, or the lines of a wheelset; `place` puts its outline where it is in a frame."""
        kind = self._shapes[name].kind
        if kind == "wheelset":
            (line,) = axis.plot([], [], color=BODY_COLOURS[kind], linewidth=1.4)
            self._add(line, lambda line, k: line.set_data(*place(name, outline, k).T))
        else:
            (box,) = axis.fill(*outline.T, facecolor=(BODY_COLOURS[kind], 0.12), edgecolor=BODY_COLOURS[kind])
            self._add(box, lambda box, k: box.set_xy(place(name, outline, k)))

    def _from_above(self, axis):
        bodies = self._vehicle.bodies
        for side in (1.0, -1.0):
            axis.axhline(side * self._lateral, color=GREY, linewidth=2.0, zorder=0)
        for body in sorted(bodies, key=lambda body: -body.centre[2]):
            self._body(axis, body.name, self._shapes[body.name].above, self._above)
        for name, pair in zip(self._one.results.wheelsets, self._one.wheelsets, strict=True):
            for wheel, (_, sign, colour) in zip(pair, SIDES, strict=True):
                self._add(axis.scatter([], [], color=colour, zorder=5, linewidths=0.0), lambda dots, k, name=name,
                          wheel=wheel, sign=sign: self._dots(dots, k, wheel, self._at(name, k), sign))  # fmt: skip
        ends = [body.x - bodies[0].x + end for body in bodies for end in self._shapes[body.name].above[:, 0]]
        axis.set_xlim(np.nanmin(ends) - 0.8, np.nanmax(ends) + 0.8)
        axis.set_ylim(2.4, -2.4)
        axis.set_aspect("equal")
        axis.set_title(f"From above, displacements x {self.magnify[0]:g}; forward is to the right")
        axis.set_ylabel("to the right [m]")
        axis.grid(visible=False)

    def _from_behind(self, axis):
        names = chain(self._vehicle, self._name)
        rail = np.array([(-0.036, 0.0), (0.036, 0.0), (0.036, 0.04), (0.008, 0.05), (0.008, 0.15), (0.07, 0.172),
                         (-0.07, 0.172), (-0.008, 0.15), (-0.008, 0.05), (-0.036, 0.04), (-0.036, 0.0)])  # fmt: skip
        for sign in (1.0, -1.0):
            axis.fill(sign * (self._lateral + rail[:, 0]), rail[:, 1], color=GREY, linewidth=0.0)
        for name in names[::-1]:
            self._body(axis, name, self._shapes[name].behind, self._behind)
        for wheel, (_, sign, colour) in zip(self._one.wheelsets[self._wheelset], SIDES, strict=True):
            self._add(axis.scatter([], [], color=colour, zorder=5, linewidths=0.0), lambda dots, k, wheel=wheel,
                      sign=sign: self._dots(dots, k, wheel, 0.0, sign, seen_behind=True))  # fmt: skip
        top = np.nanmin(self._behind(names[-1], self._shapes[names[-1]].behind, 0)[:, 1])
        axis.set_xlim(-2.3, 2.3)
        axis.set_ylim(0.45, min(top, -1.0) - 0.35)
        axis.set_aspect("equal")
        axis.set_title(f"From behind at W{self._wheelset + 1}, x {self.magnify[1]:g}")
        axis.set_xlabel("to the right [m]")
        axis.set_ylabel("down [m]")
        axis.grid(visible=False)

    def _from_near(self, axis, side, sign, colour):
        k_side = 0 if sign > 0.0 else 1
        wheel = self._one.wheelsets[self._wheelset][k_side]
        axis.set_title(f"{side.capitalize()} wheel of W{self._wheelset + 1}, to scale")
        axis.set_xlim(*CLOSE[0])
        axis.set_ylim(*CLOSE[1][::-1])
        axis.set_aspect("equal")
        axis.set_xlabel("from the tape circle, to the right [mm]")
        if self._mountings is None:
            axis.text(0.5, 0.5, "profiles not found", transform=axis.transAxes, ha="center")
            return
        mounting = self._mountings[k_side]
        (s, down), (across, rail) = outlines(mounting, 0.0)
        axis.fill(sign * np.append(across, across[[-1, 0]]), np.append(rail, [CLOSE[1][1] + 5.0] * 2), color=GREY,
                  alpha=0.5, linewidth=0.0)  # fmt: skip
        (outline,) = axis.plot([], [], color="black", linewidth=1.4)
        (forces,) = axis.plot([], [], color=GREEN, linewidth=1.8)
        dots = axis.scatter([], [], color=colour, zorder=5, linewidths=0.0)

        def placed(k, s, down):
            """Points of the wheel, given in its profile's axes, across and down on the track [mm]."""
            position, rotation = self._shown.position[self._name][k], self._shown.rotation[self._name][k]
            lateral, height = sign * (1e3 * self._lateral + s), 1e3 * mounting.radius + down  # from the centre
            across = 1e3 * position[1] + lateral - rotation[0] * height - sign * 1e3 * self._lateral
            return across, 1e3 * position[2] + height + rotation[0] * lateral

        def contacts(k):
            bears = self._shown.normal[wheel][k] > 0.0
            at = 1e3 * self._shown.on_wheel[wheel][k][bears]
            return *placed(k, at, np.interp(at, s, down)), bears

        def show_outline(line, k):
            line.set_data(*placed(k, s, down))

        def show_forces(line, k):
            y, z, bears = contacts(k)
            length = FORCE * 1e-3 * self._shown.normal[wheel][k][bears]
            angle = self._shown.angle[wheel][k][bears]
            ends = y - sign * np.sin(angle) * length, z - np.cos(angle) * length
            gap = np.full(y.size, np.nan)
            line.set_data(*(np.stack([start, end, gap], axis=1).ravel()
                            for start, end in zip((y, z), ends, strict=True)))  # fmt: skip

        def show_dots(dots, k):
            y, z, bears = contacts(k)
            dots.set_offsets(np.stack([y, z], axis=1))
            dots.set_sizes(np.full(y.size, 40.0))

        for artist, update in ((outline, show_outline), (forces, show_forces), (dots, show_dots)):
            self._add(artist, update)

    def _along(self, axis):
        s, curvature = self._one.track.s, self._one.track.curvature
        axis.fill_between(s, 1e3 * curvature, color=GREY, alpha=0.5, linewidth=0.0)
        axis.set_xlim(s[0], max(s[-1], s[0] + 1.0))
        axis.margins(y=0.3)
        axis.set_xlabel("s [m]")
        axis.set_ylabel("curvature\n[1/km]")
        self._add(axis.axvline(s[0], color=VERMILION, linewidth=1.5),
                  lambda line, k: line.set_xdata([self._shown.s[k]] * 2))  # fmt: skip
        text = axis.text(0.01, 0.72, "", transform=axis.transAxes, fontsize=9)
        self._add(text, lambda text, k: text.set_text(f"t = {self._shown.time[k]:.2f} s, s = {self._shown.s[k]:.1f} m"))

    def _at(self, name, k):
        """How far a body is ahead of the first one [m]."""
        return self._shown.position[name][k][0] - self._shown.s[k]

    def _above(self, name, outline, k):
        position, yaw = self._shown.position[name][k], self._shown.rotation[name][k][2]
        x, y = outline.T
        by = self.magnify[0]
        return np.stack([self._at(name, k) + x - by * yaw * y, y + by * (position[1] + yaw * x)], axis=1)

    def _behind(self, name, outline, k):
        positions = self._shown.position[name]
        roll = self._shown.rotation[name][k][0]
        y, z = outline.T
        rise = positions[k][2] - positions[0][2]
        by = self.magnify[1]
        down = positions[0][2] + z + by * (rise + roll * y)
        return np.stack([y + by * (positions[k][1] - roll * z), down], axis=1)

    def _dots(self, dots, k, wheel, ahead, sign, seen_behind=False):
        """Contact points on their rail, larger the more they bear."""
        normal = self._shown.normal[wheel][k]
        bears = normal > 0.0
        across = sign * (self._lateral + self._shown.on_wheel[wheel][k][bears])
        along = np.full(across.size, ahead)
        dots.set_offsets(np.stack([across, 0.0 * along] if seen_behind else [along, across], axis=1))
        dots.set_sizes(DOT * normal[bears] / 100e3)


def check(several, kind, wheelset):
    """Raise an InputError when films of results cannot be made here.

    Parameters
    ----------
    several : list of Curves
    kind : str
        One of KINDS.
    wheelset : int
        Seen from near, from 1 on.
    """
    if kind == "mp4" and not FFMpegWriter.isAvailable():
        raise InputError("--film mp4", "needs the program ffmpeg, which is not found; install it, or take page or gif")
    for one in several:
        if wheelset > len(one.wheelsets):
            message = f"{one.results.folder} has {len(one.wheelsets)} wheelsets, got {wheelset}"
            raise InputError("--wheelset", message)
