use proptest::prelude::*;

use super::*;

fn frames(text: &str) -> Vec<u32> {
    parse(text).unwrap().0
}

fn pattern(name: &str) -> Pattern {
    Pattern::parse(name).unwrap().expect(name)
}

#[test]
fn frames_ranges_and_steps_come_out_in_ascending_order_and_once() {
    assert_eq!(frames("60,1-4, 70-81x5"), [1, 2, 3, 4, 60, 70, 75, 80]);
    assert_eq!(frames("3-5,4,4294967295"), [3, 4, 5, u32::MAX]);
    assert_eq!(frames("0010"), [10]);
    assert_eq!(frames("0-999999").len(), 1_000_000);
    assert_eq!(frames("0-4294967295x4294967295"), [0, u32::MAX]);
}

#[test]
fn what_names_no_frames_is_refused_with_the_reason() {
    for (text, words) in [
        ("", "`` is not a frame"),
        ("1,,2", "`` is not a frame"),
        ("1-", "`1-` is not a frame"),
        ("-5", "`-5` is not a frame"),
        ("1-2-3", "`1-2-3` is not a frame"),
        ("1x2x3", "`1x2x3` is not a frame"),
        ("1-9x", "`1-9x` is not a frame"),
        ("a", "`a` is not a frame"),
        ("+1", "`+1` is not a frame"),
        ("1-9x0", "a step of 0"),
        ("9-1", "runs backwards"),
        ("4294967296", "above 4294967295"),
        ("0-1000000", "names 1000001 frames"),
        ("0-4294967295,0-4294967295", "names 8589934592 frames"),
    ] {
        let error = parse(text).unwrap_err();
        assert!(error.contains(words), "{text}: {error}");
    }
}

#[test]
fn missing_frames_are_shown_as_ranges() {
    assert_eq!(shown(&[1, 2, 3, 7, 9, 10, u32::MAX]), "1-3,7,9-10,4294967295");
    let every_second: Vec<u32> = (0..100_000).map(|i| 2 * i).collect();
    assert!(shown(&every_second).ends_with("34,36,38 and 99980 more"));
}

#[test]
fn both_notations_for_a_frame_number_mean_the_same() {
    for name in ["beauty.####.exr", "beauty.%04d.exr"] {
        let pattern = pattern(name);
        assert_eq!(pattern.name(7), "beauty.0007.exr");
        assert_eq!(pattern.name(123_456), "beauty.123456.exr");
        assert_eq!(pattern.frame("beauty.0007.exr"), Some(7));
        assert_eq!(pattern.frame("beauty.123456.exr"), Some(123_456));
        for other in
            ["beauty.7.exr", "beauty.00007.exr", "beauty.+007.exr", "beauty.exr", "x.0007.exr"]
        {
            assert_eq!(pattern.frame(other), None, "{other}");
        }
    }
    for name in ["#", "%d", "%01d"] {
        assert_eq!((pattern(name).name(0), pattern(name).frame("12")), ("0".into(), Some(12)));
    }
}

#[test]
fn a_name_has_one_place_for_a_frame_number_or_none() {
    for name in ["", "a.exr", "100%.exr", "%4d.exr", "%0d.exr", "%s.exr", "%04", "%.exr%"] {
        assert_eq!(Pattern::parse(name), Ok(None), "{name}");
    }
    for name in ["#.#.exr", "##_%d.exr", "%d%d", "%04d.#"] {
        assert!(Pattern::parse(name).unwrap_err().contains("two places"), "{name}");
    }
    for name in ["%033d", "%099999999999999999999999d", &"#".repeat(33)] {
        assert!(Pattern::parse(name).unwrap_err().contains("at most 32"), "{name}");
    }
    assert_eq!(pattern("%%04d.exr").name(1), "%0001.exr");
}

proptest! {
    #[test]
    fn a_name_is_read_back_as_its_frame(frame: u32, digits in 1..12_usize, text in "[a-z0-9._]*") {
        let pattern = pattern(&format!("{text}{}.exr", "#".repeat(digits)));
        prop_assert_eq!(pattern.frame(&pattern.name(frame)), Some(frame));
    }

    #[test]
    fn what_is_shown_reads_back(mut numbers in prop::collection::vec(0..40_u32, 1..40)) {
        numbers.sort_unstable();
        numbers.dedup();
        prop_assert_eq!(parse(&shown(&numbers)), Ok(Frames(numbers)));
    }

    #[test]
    fn no_text_makes_it_panic(text in ".*", name in ".*") {
        let _ = parse(&text);
        if let Ok(Some(pattern)) = Pattern::parse(&text) {
            let _ = pattern.frame(&name);
        }
    }
}
