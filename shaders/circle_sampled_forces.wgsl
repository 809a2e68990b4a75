// Forces of the circle law decided at the samples.

fn deviation(c: u32, a: u32, state: u32) -> real {
    var sum = real(0.0);
    for (var i = 0u; i < N_TIME; i++) {
        var deviation = -min(sample_of(GAP, i, state), real(0.0));
        if c != GAP {
            deviation = sample_of(TRACTION + c, i, state) - sample_of(c, i, state);
        }
        sum += basis(a, i) * deviation;
    }
    return weight(a) * sum;
}
