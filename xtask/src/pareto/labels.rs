//! Where labels go beside crowded marks: near their own, on no other, their leaders across nothing.

/// Height of the labels' letters in pixels.
pub const FONT: i32 = 13;
/// A label further away than this from its mark has a line to it.
const LEADER_FROM: i32 = 13;
/// Radius around a mark that is kept free.
const MARK: i32 = 6;
/// How often every label may move again, once all are placed.
const SWEEPS: usize = 8;

/// A rectangle in pixels: left, top, right, bottom.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place(pub i32, pub i32, pub i32, pub i32);

impl Place {
    /// A square.
    pub const fn around((x, y): (i32, i32), half: i32) -> Self {
        Self(x - half, y - half, x + half, y + half)
    }

    /// A line, level or upright, with a little air.
    pub fn along(one: (i32, i32), other: (i32, i32)) -> Self {
        Self(one.0.min(other.0) - 1, one.1.min(other.1) - 1, one.0.max(other.0) + 1, one.1.max(other.1) + 1)
    }

    const fn meets(&self, other: &Self) -> bool {
        self.0 < other.2 && other.0 < self.2 && self.1 < other.3 && other.1 < self.3
    }

    const fn inside(&self, other: &Self) -> bool {
        self.0 >= other.0 && self.1 >= other.1 && self.2 <= other.2 && self.3 <= other.3
    }

    /// Its point that is nearest to another.
    fn nearest(&self, (x, y): (i32, i32)) -> (i32, i32) {
        (x.clamp(self.0, self.2), y.clamp(self.1, self.3))
    }

    fn distance(&self, point: (i32, i32)) -> f64 {
        let near = self.nearest(point);
        f64::from(near.0 - point.0).hypot(f64::from(near.1 - point.1))
    }

    /// Whether a straight line passes through it.
    fn crossed(&self, (one, other): Line) -> bool {
        let steps = (one.0 - other.0).abs().max((one.1 - other.1).abs()).max(1);
        (0..=steps).any(|step| {
            let on = |from: i32, to: i32| from + (to - from) * step / steps;
            let (x, y) = (on(one.0, other.0), on(one.1, other.1));
            self.0 < x && x < self.2 && self.1 < y && y < self.3
        })
    }
}

/// A straight line's ends.
pub type Line = ((i32, i32), (i32, i32));

fn cross((a, b): Line, (c, d): Line) -> bool {
    let side = |from: (i32, i32), to: (i32, i32), point: (i32, i32)| {
        ((to.0 - from.0) * (point.1 - from.1) - (to.1 - from.1) * (point.0 - from.0)).signum()
    };
    side(a, b, c) * side(a, b, d) < 0 && side(c, d, a) * side(c, d, b) < 0
}

/// Room that a text of [`FONT`] takes; 0.58 of its height a letter is on the safe side for a sans-serif.
pub fn text_size(text: &str) -> (i32, i32) {
    ((text.chars().count() as f64 * f64::from(FONT) * 0.58).ceil() as i32 + 2, FONT + 3)
}

/// The line from a mark to a label that lies further away.
pub fn leader(mark: (i32, i32), place: &Place) -> Option<Line> {
    (place.distance(mark) > f64::from(LEADER_FROM)).then(|| (mark, place.nearest(mark)))
}

/// A place for each mark's label. Nothing meets but where there is no room at all; `taken` are the chart's own lines and
/// texts.
pub fn places(marks: &[((i32, i32), String)], taken: &[Place], bounds: Place) -> Vec<Place> {
    let mut places: Vec<Option<Place>> = vec![None; marks.len()];
    for _ in 0..SWEEPS {
        let before = places.clone();
        for index in 0..marks.len() {
            let cost = |place: &Place| cost(index, place, marks, &places, taken);
            let best = candidates(&marks[index]).filter(|place| place.inside(&bounds));
            let best = best.map(|place| (cost(&place), place)).min_by(|a, b| a.0.total_cmp(&b.0));
            places[index] = best.map(|(_, place)| place).or(places[index]);
        }
        if places == before {
            break;
        }
    }
    let beside = |((x, y), text): &((i32, i32), String)| {
        let (width, height) = text_size(text);
        Place(x + 10, *y, x + 10 + width, y + height)
    };
    places.into_iter().zip(marks).map(|(place, mark)| place.unwrap_or_else(|| beside(mark))).collect()
}

/// Rings of places around a mark, from near to far.
fn candidates(((x, y), text): &((i32, i32), String)) -> impl Iterator<Item = Place> {
    let (x, y, (width, height)) = (*x, *y, text_size(text));
    (0..30).flat_map(move |ring| {
        let away = 10 + ring * 5;
        let tops = [-4, -2, -1, 0, 1, 2, 4].map(|part| y - height / 2 + part * away / 4);
        let lefts = [-4, -2, 0, 2, 4].map(|part| x - width / 2 + part * (width / 2 + away) / 4);
        let sides = tops.into_iter().flat_map(move |top| [(x + away, top), (x - away - width, top)]);
        let levels = lefts.into_iter().flat_map(move |left| [(left, y - away - height), (left, y + away)]);
        sides.chain(levels).map(move |(left, top)| Place(left, top, left + width, top + height))
    })
}

/// How bad a place is: far away a little, on something or across something a lot.
fn cost(index: usize, place: &Place, marks: &[((i32, i32), String)], places: &[Option<Place>], taken: &[Place]) -> f64 {
    let mark = marks[index].0;
    let distance = place.distance(mark);
    let line = leader(mark, place);
    let mut cost = distance + taken.iter().filter(|other| place.meets(other)).count() as f64 * 500.0;
    for (other, ((x, y), _)) in marks.iter().enumerate() {
        let around = Place::around((*x, *y), MARK);
        cost += if place.meets(&around) { 1000.0 } else { 0.0 };
        if other != index {
            cost += if line.is_some_and(|line| around.crossed(line)) { 400.0 } else { 0.0 };
            // A reader takes a label for that of the nearest mark.
            cost += if place.distance((*x, *y)) < distance + 4.0 { 40.0 } else { 0.0 };
        }
    }
    for (other, there) in places.iter().enumerate() {
        let Some(there) = there.as_ref().filter(|_| other != index) else { continue };
        let their_line = leader(marks[other].0, there);
        cost += if place.meets(there) { 1000.0 } else { 0.0 };
        cost += if line.is_some_and(|line| there.crossed(line)) { 600.0 } else { 0.0 };
        cost += if their_line.is_some_and(|line| place.crossed(line)) { 600.0 } else { 0.0 };
        cost += if line.zip(their_line).is_some_and(|(one, other)| cross(one, other)) { 200.0 } else { 0.0 };
    }
    cost
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_and_leaders_meet_neither_marks_nor_one_another() {
        // Thirteen marks near one another, and a line across all of the picture.
        let marks: Vec<_> =
            (0..13).map(|n| ((400 + 16 * (n % 4), 300 + 15 * (n / 4)), format!("a-method-{n}"))).collect();
        let (bounds, taken) = (Place(60, 20, 880, 500), Place(60, 380, 880, 382));
        let places = places(&marks, &[taken], bounds);
        for (index, place) in places.iter().enumerate() {
            assert!(place.inside(&bounds) && !place.meets(&taken), "{place:?}");
            assert!(!marks.iter().any(|&(mark, _)| place.meets(&Place::around(mark, MARK))), "{place:?}");
            assert!(!places[..index].iter().any(|other| place.meets(other)), "{place:?}");
            if let Some(line) = leader(marks[index].0, place) {
                assert!(!places.iter().any(|other| other != place && other.crossed(line)), "{line:?}");
            }
        }
    }

    #[test]
    fn lines_cross_and_pass_through() {
        assert!(cross(((0, 0), (10, 10)), ((0, 10), (10, 0))) && !cross(((0, 0), (4, 4)), ((0, 10), (10, 0))));
        let place = Place(4, 4, 8, 8);
        assert!(place.crossed(((0, 0), (10, 10))) && !place.crossed(((0, 0), (10, 0))));
        assert!((place.distance((0, 8)) - 4.0).abs() < 1e-9 && place.distance((5, 5)).abs() < 1e-9);
    }
}
