"""Searches learning rate, weight decay and loss with Optuna (`train.py --tune TRIALS`).

Each trial is a short run of --steps or --minutes and stops if it falls behind the median of the others. RUN/tune.db
keeps the study; running the command again continues it.
"""

import copy

import optuna

from losses import LOSSES


def tune(o, train):
    """Calls `train(options, after_validation)` o.tune times and prints the best parameters."""
    study = optuna.create_study(study_name=o.tier, storage=f"sqlite:///{o.out}/tune.db", load_if_exists=True,
                                sampler=optuna.samplers.TPESampler(), pruner=optuna.pruners.MedianPruner())
    if o.resume:
        raise SystemExit("--tune does not take --resume: it starts its own runs and always continues the search")
    study.optimize(lambda trial: _trial(trial, o, train), n_trials=o.tune)
    print(f"best of {len(study.trials)} trials: {study.best_params}, L1 denoised/noisy {study.best_value:.4f}")


def _trial(trial, o, train):
    options = copy.copy(o)
    options.lr = trial.suggest_float("lr", 3e-4, 1e-2, log=True)
    options.weight_decay = trial.suggest_float("weight_decay", 1e-4, 1e-1, log=True)
    options.loss = trial.suggest_categorical("loss", list(LOSSES))
    options.out = o.out / f"trial{trial.number}"
    options.out.mkdir(parents=True, exist_ok=True)

    def after_validation(count, score):
        trial.report(score, count)
        if trial.should_prune():
            raise optuna.TrialPruned

    return train(options, after_validation)
