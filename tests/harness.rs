//! Proves that the comparisons of `wgdenoise_testing` can fail.

use wgdenoise::Image;
use wgdenoise::internals::reference::Tensor;
use wgdenoise_testing::{
    Random, Tolerance, assert_close, check_cases, compare, image_tensor, run_cases,
};

const EXACT: Tolerance = Tolerance { absolute: 0.0, relative: 0.0 };
const TENTH: Tolerance = Tolerance { absolute: 0.1, relative: 0.0 };

fn row(values: &[f32]) -> Tensor {
    Tensor::new(1, 1, values.len(), values.to_vec())
}

fn failure(found: &Tensor, expected: &Tensor, tolerance: Tolerance) -> String {
    compare(found, expected, tolerance).expect_err("the comparison should fail")
}

#[test]
fn equal_tensors_agree_without_any_tolerance() {
    let tensor = Random::new(1).tensor(3, 4, 5);
    assert_eq!(compare(&tensor, &tensor.clone(), EXACT), Ok(()));
}

#[test]
fn a_wrong_value_fails_and_is_named_with_its_place() {
    let expected = Random::new(2).tensor(3, 4, 5);
    let mut found = expected.clone();
    found.data[20 + 3 * 5 + 2] += 0.5;
    found.data[7] += 0.2;
    let message = failure(&found, &expected, TENTH);
    assert!(message.starts_with("2 of 60 values"), "{message}");
    assert!(message.contains("channel 1, row 3, column 2"), "{message}");
}

#[test]
#[should_panic(expected = "sums: 1 of 2 values are off")]
fn a_wrong_value_panics_under_the_name_of_the_comparison() {
    assert_close("sums", &row(&[1.0, 2.0]), &row(&[1.0, 3.0]), TENTH);
}

#[test]
fn both_parts_of_the_tolerance_count_and_no_more() {
    let tolerance = Tolerance { absolute: 0.5, relative: 0.25 };
    for (found, holds) in [(-5.5, true), (-2.5, true), (-5.6, false), (-2.4, false), (4.0, false)] {
        assert_eq!(compare(&row(&[found]), &row(&[-4.0]), tolerance).is_ok(), holds, "{found}");
    }
}

#[test]
fn nan_and_infinity_fail_on_either_side_and_on_both() {
    let wide = Tolerance { absolute: f32::MAX, relative: 1.0 };
    for broken in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        for (found, expected) in [(broken, 1.0), (1.0, broken), (broken, broken)] {
            let message = failure(&row(&[1.0, found]), &row(&[1.0, expected]), wide);
            assert!(message.contains("column 1"), "{message}");
        }
    }
}

#[test]
fn nan_is_worse_than_any_number() {
    for found in [[9.0, f32::NAN, 5.0], [5.0, f32::NAN, 9.0]] {
        let message = failure(&row(&found), &row(&[0.0; 3]), TENTH);
        assert!(message.contains("column 1: found NaN"), "{message}");
    }
}

#[test]
fn a_tolerance_of_nan_allows_nothing() {
    let tolerance = Tolerance { absolute: f32::NAN, relative: 0.0 };
    failure(&row(&[1.0]), &row(&[1.0]), tolerance);
}

#[test]
fn another_shape_fails_even_with_the_same_values() {
    let (wide, high) = (Tensor::new(1, 1, 2, vec![0.0; 2]), Tensor::new(1, 2, 1, vec![0.0; 2]));
    let message = failure(&wide, &high, TENTH);
    assert_eq!(message, "shape (1, 1, 2), expected (1, 2, 1)");
}

#[test]
fn tensors_without_values_fail() {
    failure(&row(&[]), &row(&[]), TENTH);
    let mut short = row(&[1.0, 2.0]);
    short.data.pop();
    failure(&short, &row(&[1.0, 2.0]), TENTH);
    failure(&row(&[1.0, 2.0]), &short, TENTH);
}

#[test]
fn an_empty_table_fails() {
    let result = check_cases([0; 0], |_| Ok(()));
    assert_eq!(result, Err("the table has no cases, so nothing was tested".into()));
}

#[test]
fn every_case_runs_and_all_that_failed_are_listed() {
    let mut seen = Vec::new();
    let result = check_cases([1, 2, 3, 4], |&case| {
        seen.push(case);
        if case % 2 == 0 { Err(format!("{case} is even")) } else { Ok(()) }
    });
    assert_eq!(seen, [1, 2, 3, 4]);
    assert_eq!(result, Err("2 of 4 cases failed:\n  2: 2 is even\n  4: 4 is even".into()));
    assert_eq!(check_cases([1, 3], |_| Ok(())), Ok(()));
}

#[test]
#[should_panic(expected = "1 of 1 cases failed")]
fn a_failed_case_panics() {
    run_cases(["only"], |_| Err("broken".into()));
}

#[test]
#[should_panic(expected = "no cases")]
fn an_empty_table_panics() {
    run_cases([0; 0], |_| Ok(()));
}

#[test]
fn random_values_repeat_by_seed_and_fill_their_range() {
    let values = Random::new(3).values(10_000);
    assert_eq!(values, Random::new(3).values(10_000));
    assert_ne!(values, Random::new(4).values(10_000));
    assert!(values.iter().all(|v| (-1.0..1.0).contains(v)));
    assert!(values.iter().any(|&v| v < -0.99) && values.iter().any(|&v| v > 0.99));
    assert!(values.iter().sum::<f32>().abs() < 200.0, "the mean is far from 0");
}

#[test]
fn an_image_becomes_a_tensor_of_its_channels() {
    let pixels = vec![[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]];
    let found = image_tensor(&Image::new(1, 2, pixels).expect("a valid image"));
    assert_eq!(found, Tensor::new(3, 2, 1, vec![1.0, 4.0, 2.0, 5.0, 3.0, 6.0]));
}
