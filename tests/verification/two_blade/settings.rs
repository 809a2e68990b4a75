//! Settings of the rig that are refused.

use microslip::model::two_blade::TwoBladeSettings;

type Change = fn(&mut TwoBladeSettings);

#[test]
fn settings_name_the_broken_rule() {
    let cases: [(&str, Change); 12] = [
        ("gap_mm", |s| s.gap_mm = 0.0),
        ("neck_mm", |s| s.neck_mm = [41.0, 10.0, 20.0]),
        ("strip_mm", |s| s.strip_mm = [15.0, 50.0, 0.4]),
        ("strip_mm", |s| s.strip_mm = [10.0, 50.0, 19.0]),
        ("blade_cut_off_hz", |s| s.blade_cut_off_hz = 0.0),
        ("strip_cut_off_hz", |s| s.strip_cut_off_hz = f64::INFINITY),
        ("contact_nodes", |s| s.contact_nodes = [5, 1]),
        ("contact_spacing_at_gap", |s| s.contact_spacing_at_gap = 1.1),
        ("contact_spacing_at_gap", |s| {
            s.contact_nodes = [2, 3];
            s.contact_spacing_at_gap = 0.8;
        }),
        ("poisson_ratio", |s| s.poisson_ratio = 0.5),
        ("pressure_weights", |s| {
            s.pressure_weights = Some(vec![1.0; 3])
        }),
        ("response_height", |s| s.response_height = 1.5),
    ];
    for (key, change) in cases {
        let mut settings = TwoBladeSettings::default();
        change(&mut settings);
        assert_eq!(settings.validate().expect_err("rule broken").key, key);
    }
    assert!(
        toml::from_str::<TwoBladeSettings>("gap_mm = 0.6\nneck_m = 1").is_err(),
        "unknown key"
    );
}
