// Spectra of masks over the period, from antiderivatives at the ends of their stretches, and Gram matrices from them
// (`gram`, the twin of `add_masked_gram` in aft/lanes/masks.rs).
// In front of this text stands MASKS, their number; the last one is that of the open contact.

// Orders in the spectrum of a mask.
const N_ORDERS: u32 = 2u * HIGHEST + 1u;
const MASK_OPEN: u32 = MASKS - 1u;

// Shape: [mask][cos, sin][N_ORDERS][state]
@group(0) @binding(9) var<storage, read_write> spectra: array<real>;

const SPECTRA_PER_STATE: u32 = 2u * MASKS * N_ORDERS;

fn spectrum_at(mask: u32, trig: u32, order: u32, state: u32) -> u32 {
    return ((mask * 2u + trig) * N_ORDERS + order) * batch.n_states + state;
}

fn add(mask: u32, order: u32, factor: real, cosine: real, sine: real, state: u32) {
    spectra[spectrum_at(mask, 0u, order, state)] += factor * cosine;
    spectra[spectrum_at(mask, 1u, order, state)] += factor * sine;
}

// Entry (a, b) of the Gram matrix of the basis over a mask, per period.
fn gram(mask: u32, a: u32, b: u32, state: u32) -> real {
    let p = order_of(a);
    let q = order_of(b);
    let sine_a = a > 0u && a % 2u == 0u;
    let sine_b = b > 0u && b % 2u == 0u;
    if a == 0u || b == 0u {
        // the constant times one function of the basis
        let trig = select(0u, 1u, sine_a || sine_b);
        let value = spectra[spectrum_at(mask, trig, p + q, state)];
        return select(value + value, value, a == 0u);
    }
    let trig = select(0u, 1u, sine_a != sine_b);
    let sum = spectra[spectrum_at(mask, trig, p + q, state)];
    let distance = spectra[spectrum_at(mask, trig, select(q - p, p - q, p >= q), state)];
    if sine_a == sine_b {
        return select(distance + sum, distance - sum, sine_a);
    }
    // sin(p - q) changes its sign with its argument; cos p sin q has the opposite one
    let signed = select(-distance, distance, p >= q);
    return select(sum - signed, sum + signed, sine_a);
}

struct Turn {
    cosine: real,
    sine: real,
}

// cos and sin of a part of one step, by their series: the trigonometric functions of the language are too coarse in f32
// and absent in f64.
fn part_of_step(share: real) -> Turn {
    let x = share * STEP;
    var turn = Turn(real(0.0), real(0.0));
    var power = real(1.0);
    for (var t = 0u; t < TERMS; t++) {
        let term = select(power, -power, t % 4u >= 2u);
        if t % 2u == 0u {
            turn.cosine += term;
        } else {
            turn.sine += term;
        }
        power *= x / real(t + 1u);
    }
    return turn;
}

// e^{ik(phase i + part)} for the part's k-th power.
fn turned(k: u32, i: u32, part: Turn) -> Turn {
    let phase = (k * i) % N_TIME;
    let cosine = circle[phase];
    let sine = circle[N_TIME + phase];
    return Turn(cosine * part.cosine - sine * part.sine, sine * part.cosine + cosine * part.sine);
}

// e^{ik(phase i + part)}.
fn turn_at(k: u32, i: u32, part: Turn) -> Turn {
    var power = Turn(real(1.0), real(0.0));
    for (var j = 0u; j < k; j++) {
        power = times(power, part);
    }
    return turned(k, i, power);
}

fn times(a: Turn, b: Turn) -> Turn {
    return Turn(a.cosine * b.cosine - a.sine * b.sine, a.sine * b.cosine + a.cosine * b.sine);
}

// Coefficient a of the gap function while the contact is open.
fn open_gap(a: u32, state: u32) -> real {
    var sum = gram(MASK_OPEN, a, 0u, state) * states[batch.n_states + state];
    for (var b = 1u; b < M; b++) {
        sum += gram(MASK_OPEN, a, b, state) * coefficient(GAP, (b - 1u) / 2u, (b - 1u) % 2u, state);
    }
    return sum;
}
