use super::*;
use crate::shaping::fixtures::on_grid;
use crate::shaping::heat::HeatPotential;
use faer::Mat;
use training::{PATIENCE, PROGRESS};

fn potential(params: ShapingParams) -> LearnedTemperaturePotential {
    LearnedTemperaturePotential::new(params, GcnParams::default(), 3)
}

/// As far as it gets, however small the loss.
fn to_the_end() -> ShapingParams {
    ShapingParams {
        fit_tolerance: 0.0,
        ..Default::default()
    }
}

#[test]
fn training_lowers_the_loss_and_later_fits_leave_the_network_alone() {
    on_grid(8, |context| {
        let mut model = potential(to_the_end());
        let cold = model.fit_to_returns(context).unwrap().fit.unwrap();
        assert!(cold.loss < 0.9 * cold.initial_loss, "{cold:?}");
        let weights = model.parameters().cloned();
        let warm = model.fit_to_returns(context).unwrap().fit.unwrap();
        assert_eq!(warm.epochs, 0);
        assert!(
            warm.initial_loss < RELAPSE * cold.loss,
            "{warm:?} after {cold:?}"
        );
        assert_eq!(model.parameters(), weights.as_ref());
    });
}

#[test]
fn a_loss_that_has_grown_is_trained_away_again() {
    on_grid(8, |context| {
        let mut model = potential(to_the_end());
        model.fit_to_returns(context).unwrap();
        model.learnt = model.learnt.map(|loss| loss / 2.0);
        let again = model.fit_to_returns(context).unwrap().fit.unwrap();
        assert!(0 < again.epochs && again.epochs <= 20, "{again:?}");
    });
}

#[test]
fn training_goes_on_while_it_pays() {
    on_grid(8, |context| {
        let fit = |cold_epochs| {
            let shaping = ShapingParams {
                cold_epochs,
                ..to_the_end()
            };
            let fit = potential(shaping).fit_to_returns(context).unwrap();
            fit.fit.unwrap()
        };
        let all = fit(100_000);
        assert!(all.epochs < 1000 && all.epochs % PATIENCE == 0, "{all:?}");
        // Of all stretches but the last each has paid.
        let losses: Vec<f64> = (0..=all.epochs / PATIENCE)
            .map(|stretches| fit(stretches * PATIENCE).loss)
            .collect();
        let pays = |pair: &[f64]| pair[1] <= (1.0 - PROGRESS) * pair[0];
        let paid: Vec<bool> = losses.windows(2).map(pays).collect();
        let (last, others) = paid.split_last().unwrap();
        assert!(!last && others.iter().all(|&paid| paid), "{losses:?}");
    });
}

#[test]
fn training_ends_at_the_tolerance_and_does_not_begin_below_it() {
    on_grid(8, |context| {
        let fit = |fit_tolerance| {
            let shaping = ShapingParams {
                fit_tolerance,
                ..Default::default()
            };
            potential(shaping)
                .fit_to_returns(context)
                .unwrap()
                .fit
                .unwrap()
        };
        let full = fit(0.0);
        let half = fit(0.5 * (full.initial_loss + full.loss));
        assert!(0 < half.epochs && half.epochs < 150, "{half:?}");
        assert!(full.loss < half.loss && half.loss < half.initial_loss);
        let none = fit(full.initial_loss);
        assert_eq!((none.epochs, none.loss), (0, full.initial_loss));
    });
}

/// The last output only saves time.
#[test]
fn what_is_remembered_does_not_show() {
    on_grid(8, |context| {
        let mut model = potential(to_the_end());
        model.fit_to_returns(context).unwrap();
        let mut forgetful = model.clone();
        forgetful.last = None;
        let warm = model.fit_to_returns(context).unwrap();
        assert_eq!(warm, forgetful.fit_to_returns(context).unwrap());
    });
}

/// Carried weights give the potential that they gave where they were fitted, without an epoch.
#[test]
fn weights_can_be_carried_over() {
    on_grid(4, |context| {
        let mut fitted = potential(ShapingParams::default());
        assert!(fitted.parameters().is_none());
        fitted.fit_to_returns(context).unwrap();
        let as_they_are = ShapingParams {
            warm_epochs: 0,
            ..Default::default()
        };
        let weights = fitted.parameters().unwrap().clone();
        let carry = |weights| potential(as_they_are.clone()).with_parameters(weights);
        let carried = carry(weights.clone())
            .unwrap()
            .fit_to_returns(context)
            .unwrap();
        fitted.shaping.warm_epochs = 0;
        fitted.last = None;
        assert_eq!(
            carried.values,
            fitted.fit_to_returns(context).unwrap().values
        );

        let mut rng = stream(0, Stream::Gcn);
        let two: GcnParameters = Gcn::new(4, 3, 2, true, &mut rng).into();
        assert!(matches!(
            carry(two),
            Err(GcnError::Outputs { found: 2, .. })
        ));
        let mut nan = weights;
        nan.slices_mut().next().unwrap()[0] = f64::NAN;
        assert!(matches!(carry(nan), Err(GcnError::NotFinite { .. })));
    });
}

#[test]
fn untrained_it_is_heat_at_its_temperature() {
    on_grid(4, |context| {
        let no_epochs = ShapingParams {
            cold_epochs: 0,
            ..Default::default()
        };
        let kept = (-1.0 / no_epochs.temperature).exp();
        let scale_factor = no_epochs.scale_factor;
        let untrained = potential(no_epochs).fit_to_returns(context).unwrap().values;
        let mut heat = HeatPotential { kept, scale_factor };
        let heat = heat.fit_to_returns(context).unwrap().values;
        for (a, b) in untrained.iter().zip(&heat) {
            assert!((a - b).abs() < 1e-5, "{a} against {b}");
        }
    });
}

#[test]
fn features_with_nan_are_an_error_and_leave_the_weights() {
    on_grid(4, |context| {
        let mut model = potential(ShapingParams::default());
        model.fit_to_returns(context).unwrap();
        let before = model.network.clone();
        let nan = Mat::full(72, 4, f64::NAN);
        let error = model
            .fit_to_returns(&ReturnContext {
                features: nan.as_ref(),
                ..*context
            })
            .unwrap_err();
        assert!(matches!(error, ShapingError::Gcn(_)), "{error}");
        assert_eq!(model.network, before);
        assert!(model.fit_to_returns(context).is_ok());
    });
}

#[test]
fn equal_seeds_give_equal_bits() {
    on_grid(4, |context| {
        let fit = || {
            potential(ShapingParams::default())
                .fit_to_returns(context)
                .unwrap()
        };
        assert_eq!(fit(), fit());
    });
}

/// Each fit draws labels of its own.
#[test]
fn labels_are_drawn_anew_from_the_returns() {
    on_grid(1, |context| {
        let mut model = potential(ShapingParams {
            num_labels: 20,
            ..Default::default()
        });
        let first = model.draw_labels(context.returns);
        assert_eq!(first.len(), 20);
        for (i, label) in first.iter().enumerate() {
            assert!(context.returns.contains(label), "{label:?}");
            assert!(!first[..i].contains(label), "{label:?} twice");
        }
        assert_eq!(model.draw_labels(context.returns), first);
        model.fits += 1;
        let second = model.draw_labels(context.returns);
        let both = second.iter().filter(|label| first.contains(label)).count();
        assert!(second.len() == 20 && both < 15, "{both} of 20 once more");
    });
}

/// Without a return there is nothing to learn, and nothing to lose.
#[test]
fn without_returns_it_is_not_trained() {
    on_grid(3, |context| {
        let mut model = potential(to_the_end());
        let nobody_has_been_here = ReturnContext {
            returns: &[],
            ..*context
        };
        let fit = model.fit_to_returns(&nobody_has_been_here).unwrap();
        let fit = fit.fit.unwrap();
        assert_eq!((fit.epochs, fit.loss), (0, 0.0));
        // With the first ones it is.
        let fit = model.fit_to_returns(context).unwrap().fit.unwrap();
        assert!(fit.epochs > 0);
    });
}

/// The agent acts as well as the optimal policy: V comes nearer to its value.
#[test]
fn returns_of_shortest_ways_lower_the_temperature() {
    on_grid(8, |context| {
        let mut model = potential(to_the_end());
        let cold = model.fit_to_returns(context).unwrap().values;
        let mut heat = HeatPotential {
            kept: (-1.0 / ShapingParams::default().temperature).exp(),
            scale_factor: 1.0,
        };
        let heat = heat.fit_to_returns(context).unwrap().values;
        let error = |phi: &[f64]| -> f64 {
            let returns = context.returns.iter();
            returns
                .map(|&(state, g)| ((phi[state.index()] - g) / g).powi(2))
                .sum()
        };
        assert!(
            error(&cold) < 0.5 * error(&heat),
            "{} against {}",
            error(&cold),
            error(&heat)
        );
    });
}

#[test]
fn the_factor_multiplies_and_is_not_learnt() {
    on_grid(4, |context| {
        let fit = |scale_factor| {
            let shaping = ShapingParams {
                scale_factor,
                ..Default::default()
            };
            potential(shaping).fit_to_returns(context).unwrap()
        };
        let (single, triple) = (fit(1.0), fit(3.0));
        assert_eq!(single.fit, triple.fit);
        for (a, b) in single.values.iter().zip(&triple.values) {
            assert_eq!(3.0 * a, *b);
        }
    });
}

/// Written down and read back between two fits, it goes on to the same bits.
#[test]
fn read_back_it_goes_on_as_if_nothing_had_been() {
    on_grid(4, |context| {
        let mut kept = potential(to_the_end());
        kept.fit_to_returns(context).unwrap();
        let bytes = postcard::to_stdvec(&kept).unwrap();
        let mut read: LearnedTemperaturePotential = postcard::from_bytes(&bytes).unwrap();
        assert!(read == kept);
        // Other returns, far from those that were learnt.
        let doubled: Vec<_> = context.returns.iter().map(|&(s, g)| (s, 2.0 * g)).collect();
        let later = ReturnContext {
            returns: &doubled,
            ..*context
        };
        let [a, b] = [&mut kept, &mut read].map(|model| model.fit_to_returns(&later).unwrap());
        assert_eq!(a, b);
        assert_eq!(a.fit.unwrap().epochs, 20);
    });
}
