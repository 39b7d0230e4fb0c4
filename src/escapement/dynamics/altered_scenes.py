"""Scenes of which some numbers differ from another scene: `Scene._replace` for kernels."""

from escapement.model.scene import Scene
from escapement.numerics.jit import inner_jit


@inner_jit(inlined=True)
def _given(value, otherwise):
    return otherwise if value is None else value


@inner_jit(inlined=True)
def scene_with(
    scene, path=None, driver_angle=None, rho=None, mu_plus=None, mu_minus=None, load=None,
    bearing=None,
    driver_drag=None, follower_drag=None, driver_viscous=None, follower_viscous=None,
    driver_journal=None, follower_journal=None, gain=None, flow=None,
    barrel_efficiency=None, load_train_efficiency=None,
):  # fmt: skip
    """The scene with other values of the fields that are given by their names."""
    return Scene(
        path=_given(path, scene.path),
        edges=scene.edges,
        dwell=scene.dwell,
        torque=scene.torque,
        driver_angle=_given(driver_angle, scene.driver_angle),
        rho=_given(rho, scene.rho),
        mu_plus=_given(mu_plus, scene.mu_plus),
        mu_minus=_given(mu_minus, scene.mu_minus),
        load=_given(load, scene.load),
        bearing=_given(bearing, scene.bearing),
        driver_drag=_given(driver_drag, scene.driver_drag),
        follower_drag=_given(follower_drag, scene.follower_drag),
        driver_viscous=_given(driver_viscous, scene.driver_viscous),
        follower_viscous=_given(follower_viscous, scene.follower_viscous),
        pin=scene.pin,
        driver_journal=_given(driver_journal, scene.driver_journal),
        follower_journal=_given(follower_journal, scene.follower_journal),
        gain=_given(gain, scene.gain),
        flow=_given(flow, scene.flow),
        barrel=scene.barrel,
        barrel_efficiency=_given(barrel_efficiency, scene.barrel_efficiency),
        load_train=scene.load_train,
        load_train_efficiency=_given(load_train_efficiency, scene.load_train_efficiency),
    )
