//! Contacts of a MuJoCo model at the end of a tick: forces on elements, fingertips and objects, and
//! slip.
//!
//! ```text
//!  MjData: contacts, constraint forces, positions ─▶ Contacts ─▶ forces, touched objects, slip
//! ```
//!
//! * **Invariants:** equal data give equal bits.
//! * **Not included:** the motion itself, which is MuJoCo's. NumPy would take longer for these sums
//!   than MuJoCo for a step.

use numpy::ndarray::{ArrayView2, Dimension};
use numpy::{
    Element, PyArray, PyArray1, PyArrayMethods, PyReadonlyArray, PyReadonlyArray1, PyReadonlyArray2,
};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

/// Half extents of a box, or radius and half height of a cylinder, m.
#[derive(Clone, Copy, Debug)]
enum Shape {
    Box([f64; 3]),
    Cylinder([f64; 2]),
}

/// Object of the scene.
#[derive(Clone, Copy, Debug)]
struct Thing {
    body: usize,
    shape: Shape,
}

/// Pin of a fingertip's skin.
#[derive(Clone, Debug)]
struct Pin {
    geom: usize,
    tip: usize,
    element: usize,
    qpos: [usize; 3],
    dof: [usize; 3],
    stiffness_n_m: [f64; 3],
    damping_n_s_m: [f64; 3],
    /// Axes of the joints, tip frame.
    axes: [[f64; 3]; 3],
    /// Normal force, N.
    pressed_n: f64,
    /// Position in the frame of the touched object, m.
    on_object_m: [f64; 3],
}

/// Fingertip.
#[derive(Clone, Copy, Debug, Default)]
struct Tip {
    body: usize,
    normal_n: f64,
    slip_m: f64,
    touched: Option<usize>,
    /// It touched the same object in the previous tick.
    goes_on: bool,
}

/// Contacts of one MuJoCo model.
#[pyclass(module = "atas._native")]
pub(crate) struct Contacts {
    things: Vec<Thing>,
    pins: Vec<Pin>,
    tips: Vec<Tip>,
    pin_of_geom: Vec<Option<usize>>,
    thing_of_geom: Vec<Option<usize>>,
    elements_n: Vec<[f64; 3]>,
    support_n: Vec<f64>,
    /// The positions of the pins are those of the previous tick.
    has_positions: bool,
}

/// Numbers of a pin: geometry, fingertip and element; addresses of positions and velocities;
/// stiffness, N/m; damping, N·s/m; axes, tip frame.
type PinNumbers = (
    usize,
    usize,
    usize,
    [usize; 3],
    [usize; 3],
    [f64; 3],
    [f64; 3],
    [[f64; 3]; 3],
);
type Vector<'py> = PyReadonlyArray1<'py, f64>;
type Table<'py> = PyReadonlyArray2<'py, f64>;
type Numbers<'py> = Bound<'py, PyArray1<f64>>;
type Indices<'py> = Bound<'py, PyArray1<i64>>;
type Arrays<'py> = (
    Numbers<'py>,
    Numbers<'py>,
    Numbers<'py>,
    Indices<'py>,
    Numbers<'py>,
);

#[pymethods]
impl Contacts {
    /// Describes a model. `objects`: body, and half extents of a box or radius and half height of a
    /// cylinder, m; `object_of_geom`: index or −1.
    #[new]
    fn new(
        objects: Vec<(usize, Vec<f64>)>,
        object_of_geom: Vec<i64>,
        tip_bodies: Vec<usize>,
        elements: usize,
        pins: Vec<PinNumbers>,
    ) -> PyResult<Self> {
        let shape = |sizes: &[f64]| match *sizes {
            [x, y, z] => Ok(Shape::Box([x, y, z])),
            [radius, half] => Ok(Shape::Cylinder([radius, half])),
            _ => Err(PyValueError::new_err("a shape needs two or three sizes")),
        };
        let things = objects.iter().map(|(body, sizes)| {
            Ok(Thing {
                body: *body,
                shape: shape(sizes)?,
            })
        });
        let things: Vec<Thing> = things.collect::<PyResult<_>>()?;
        let thing_of_geom: Vec<Option<usize>> = object_of_geom
            .iter()
            .map(|&index| {
                usize::try_from(index)
                    .ok()
                    .filter(|&index| index < things.len())
            })
            .collect();
        let mut pin_of_geom = vec![None; thing_of_geom.len()];
        for (index, pin) in pins.iter().enumerate() {
            let slot = pin_of_geom.get_mut(pin.0);
            *slot.ok_or_else(|| PyValueError::new_err("a pin has no geometry"))? = Some(index);
            if pin.1 >= tip_bodies.len() || pin.2 >= elements {
                return Err(PyValueError::new_err("a pin has no fingertip or element"));
            }
        }
        let pins = pins.into_iter().map(|pin| Pin {
            geom: pin.0,
            tip: pin.1,
            element: pin.2,
            qpos: pin.3,
            dof: pin.4,
            stiffness_n_m: pin.5,
            damping_n_s_m: pin.6,
            axes: pin.7,
            pressed_n: 0.0,
            on_object_m: [0.0; 3],
        });
        let tips = tip_bodies.into_iter().map(|body| Tip {
            body,
            ..Tip::default()
        });
        Ok(Self {
            support_n: vec![0.0; things.len()],
            things,
            pins: pins.collect(),
            tips: tips.collect(),
            pin_of_geom,
            thing_of_geom,
            elements_n: vec![[0.0; 3]; elements],
            has_positions: false,
        })
    }

    /// Continues the slip of another model's contacts; positions of pins are forgotten.
    fn continue_from(&mut self, other: PyRef<'_, Self>) {
        for (tip, other) in self.tips.iter_mut().zip(&other.tips) {
            *tip = Tip {
                body: tip.body,
                ..*other
            };
        }
        self.has_positions = false;
    }

    /// Reads MuJoCo's data at the end of a tick. Returns the forces on elements (tip frame) and
    /// fingertips, N, the slip of fingertips, m, the touched objects or −1, and the vertical forces
    /// of supports on objects, N.
    fn read<'py>(&mut self, data: &Bound<'py, PyAny>) -> PyResult<Arrays<'py>> {
        let py = data.py();
        self.read_forces(data)?;
        self.read_elements(data)?;
        self.update_slip(data)?;
        let of_tips = |value: fn(&Tip) -> f64| self.tips.iter().map(value).collect::<Vec<_>>();
        let touched = |tip: &Tip| tip.touched.map_or(-1, |index| index as i64);
        Ok((
            PyArray1::from_slice(py, self.elements_n.as_flattened()),
            PyArray1::from_vec(py, of_tips(|tip| tip.normal_n)),
            PyArray1::from_vec(py, of_tips(|tip| tip.slip_m)),
            PyArray1::from_vec(py, self.tips.iter().map(touched).collect()),
            PyArray1::from_slice(py, &self.support_n),
        ))
    }

    /// Returns the distance of each fingertip's origin from the nearest object, m, and the object
    /// that it touches, or else the nearest one.
    fn nearest<'py>(&self, data: &Bound<'py, PyAny>) -> PyResult<(Numbers<'py>, Indices<'py>)> {
        let (places, axes): (Table<'_>, Table<'_>) = (get(data, "xpos")?, get(data, "xmat")?);
        let (places, axes) = (places.as_array(), axes.as_array());
        let (mut distances_m, mut indices) = (Vec::new(), Vec::new());
        for tip in &self.tips {
            let tip_m = row(&places, tip.body)?;
            let (mut least_m, mut nearest) = (f64::INFINITY, 0);
            for (index, thing) in self.things.iter().enumerate() {
                let distance_m = thing.distance_m(in_frame(&places, &axes, thing.body, tip_m)?);
                if distance_m < least_m {
                    (least_m, nearest) = (distance_m, index);
                }
            }
            distances_m.push(least_m);
            indices.push(tip.touched.unwrap_or(nearest) as i64);
        }
        let py = data.py();
        Ok((
            PyArray1::from_vec(py, distances_m),
            PyArray1::from_vec(py, indices),
        ))
    }
}

impl Contacts {
    /// Reads the forces on pins and those of supports on objects.
    fn read_forces(&mut self, data: &Bound<'_, PyAny>) -> PyResult<()> {
        self.pins.iter_mut().for_each(|pin| pin.pressed_n = 0.0);
        self.support_n.fill(0.0);
        let objects = self.things.len();
        let mut share_n = vec![0.0; self.tips.len() * objects];
        let contact = data.getattr("contact")?;
        let geoms: PyReadonlyArray2<'_, i32> = get(&contact, "geom")?;
        let address: PyReadonlyArray1<'_, i32> = get(&contact, "efc_address")?;
        let (frame, force): (Table<'_>, Vector<'_>) =
            (get(&contact, "frame")?, get(data, "efc_force")?);
        let (geoms, frame, force) = (geoms.as_array(), frame.as_array(), force.as_array());
        for (index, &address) in address.as_array().iter().enumerate() {
            // A contact beyond its gap has no rows.
            let Ok(address) = usize::try_from(address) else {
                continue;
            };
            let of = |table: &[Option<usize>], side: usize| {
                let geom = usize::try_from(*geoms.get((index, side))?).ok()?;
                *table.get(geom)?
            };
            let along = |axis: usize| force.get(address + axis).copied().unwrap_or_default();
            let things = [of(&self.thing_of_geom, 0), of(&self.thing_of_geom, 1)];
            let pin = of(&self.pin_of_geom, 0).or_else(|| of(&self.pin_of_geom, 1));
            let thing = things[1].or(things[0]);
            match (pin, thing) {
                (Some(pin), Some(thing)) => {
                    let pin = &mut self.pins[pin];
                    pin.pressed_n += along(0);
                    share_n[pin.tip * objects + thing] += along(0);
                }
                (None, Some(thing)) => {
                    // MuJoCo's force acts on the second geometry, along the rows of the frame.
                    let sign = if things[1].is_some() { 1.0 } else { -1.0 };
                    let up = |axis: usize| frame.get((index, 3 * axis + 2)).copied();
                    let terms = (0..3).map(|axis| up(axis).unwrap_or_default() * along(axis));
                    self.support_n[thing] += sign * terms.sum::<f64>();
                }
                (_, None) => {}
            }
        }
        for (tip, share_n) in self.tips.iter_mut().zip(share_n.chunks(objects.max(1))) {
            let most = share_n.iter().enumerate().max_by(|a, b| a.1.total_cmp(b.1));
            tip.normal_n = share_n.iter().sum();
            let touched = most.filter(|_| tip.normal_n > 0.0).map(|(index, _)| index);
            tip.goes_on = touched == tip.touched;
            tip.touched = touched;
            if touched.is_none() {
                tip.slip_m = 0.0;
            }
        }
        Ok(())
    }

    /// Reads the forces that deflect the pins.
    fn read_elements(&mut self, data: &Bound<'_, PyAny>) -> PyResult<()> {
        let (q, v): (Vector<'_>, Vector<'_>) = (get(data, "qpos")?, get(data, "qvel")?);
        let (q, v) = (q.as_array(), v.as_array());
        self.elements_n.fill([0.0; 3]);
        for pin in &self.pins {
            for joint in 0..3 {
                let (q_m, v_m_s) = (q.get(pin.qpos[joint]), v.get(pin.dof[joint]));
                let (Some(q_m), Some(v_m_s)) = (q_m, v_m_s) else {
                    return Err(PyValueError::new_err("a pin has no joint"));
                };
                let along_n = pin.stiffness_n_m[joint] * q_m + pin.damping_n_s_m[joint] * v_m_s;
                for (sum_n, axis) in self.elements_n[pin.element].iter_mut().zip(pin.axes[joint]) {
                    *sum_n += along_n * axis;
                }
            }
        }
        Ok(())
    }

    /// Adds the motion of the pressed pins on the surface, weighted by their force.
    fn update_slip(&mut self, data: &Bound<'_, PyAny>) -> PyResult<()> {
        if self.tips.iter().all(|tip| tip.touched.is_none()) {
            self.has_positions = false;
            return Ok(());
        }
        let (places, axes): (Table<'_>, Table<'_>) = (get(data, "xpos")?, get(data, "xmat")?);
        let pins: Table<'_> = get(data, "geom_xpos")?;
        let (places, axes, pins_m) = (places.as_array(), axes.as_array(), pins.as_array());
        for pin in &mut self.pins {
            let tip = &mut self.tips[pin.tip];
            let Some(thing) = tip.touched else { continue };
            let body = self.things[thing].body;
            let now_m = in_frame(&places, &axes, body, row(&pins_m, pin.geom)?)?;
            let before_m = core::mem::replace(&mut pin.on_object_m, now_m);
            if self.has_positions && tip.goes_on {
                let way = core::array::from_fn::<f64, 3, _>(|axis| now_m[axis] - before_m[axis]);
                let moved_m = way.iter().map(|m| m * m).sum::<f64>().sqrt();
                tip.slip_m += pin.pressed_n * moved_m / tip.normal_n.max(1e-9);
            }
        }
        self.has_positions = true;
        Ok(())
    }
}

impl Thing {
    /// Returns the distance of a point in the object's frame, m; 0 inside.
    fn distance_m(&self, point_m: [f64; 3]) -> f64 {
        let [x, y, z] = point_m;
        match self.shape {
            Shape::Box(half_m) => {
                let beyond = [x, y, z].into_iter().zip(half_m);
                let squares = beyond.map(|(at, half)| (at.abs() - half).max(0.0).powi(2));
                squares.sum::<f64>().sqrt()
            }
            Shape::Cylinder([radius_m, half_m]) => {
                let (out, up) = (x.hypot(y) - radius_m, z.abs() - half_m);
                out.max(0.0).hypot(up.max(0.0))
            }
        }
    }
}

/// Returns an attribute of MuJoCo's data as an array.
fn get<'py, T: Element, D: Dimension>(
    from: &Bound<'py, PyAny>,
    name: &str,
) -> PyResult<PyReadonlyArray<'py, T, D>> {
    let value = from.getattr(name)?;
    Ok(value.cast::<PyArray<T, D>>()?.readonly())
}

fn row(table: &ArrayView2<'_, f64>, index: usize) -> PyResult<[f64; 3]> {
    let values = [0, 1, 2].map(|column| table.get((index, column)).copied());
    match values {
        [Some(x), Some(y), Some(z)] => Ok([x, y, z]),
        _ => Err(PyValueError::new_err("a part is not in the model")),
    }
}

/// Returns a point in the frame of a body, m.
fn in_frame(
    places_m: &ArrayView2<'_, f64>,
    axes: &ArrayView2<'_, f64>,
    body: usize,
    point_m: [f64; 3],
) -> PyResult<[f64; 3]> {
    let place_m = row(places_m, body)?;
    let from_m = [0, 1, 2].map(|axis| point_m[axis] - place_m[axis]);
    let along = |column: usize| {
        let term = |axis: usize| {
            axes.get((body, 3 * axis + column))
                .map(|a| a * from_m[axis])
        };
        Some(term(0)? + term(1)? + term(2)?)
    };
    match [along(0), along(1), along(2)] {
        [Some(x), Some(y), Some(z)] => Ok([x, y, z]),
        _ => Err(PyValueError::new_err("a part is not in the model")),
    }
}
