"""The optimizers for `train.py --optimizer`, as functions of the model, peak learning rate and weight decay."""

import torch


def adamw(model, lr, weight_decay):
    """AdamW without weight decay for biases and norms."""
    matrices = [p for p in model.parameters() if p.ndim > 1]
    vectors = [p for p in model.parameters() if p.ndim == 1]
    groups = [dict(params=matrices, weight_decay=weight_decay), dict(params=vectors, weight_decay=0.0)]
    return torch.optim.AdamW(groups, lr=lr, fused=True)


def muon(model, lr, weight_decay):
    """Muon for the convolutions that produce features, AdamW for the rest."""
    parameters = dict(model.named_parameters())
    kernels = [p for name, p in parameters.items() if p.ndim > 1 and not name.startswith(("kernel_conv", "out_conv"))]
    others = [p for p in parameters.values() if not any(p is k for k in kernels)]
    return Both(Muon(kernels, lr, weight_decay), torch.optim.AdamW(others, lr=lr, weight_decay=0.0, fused=True))


class Muon(torch.optim.Optimizer):
    """Steps along the orthogonalized momentum (Jordan et al. 2024) of each kernel, flattened to a matrix [first, rest].

    Steps are scaled to the RMS of AdamW's, so the same learning rate suits both (Liu et al. 2025).
    """

    def __init__(self, kernels, lr, weight_decay, momentum=0.95):
        super().__init__(kernels, dict(lr=lr, weight_decay=weight_decay, momentum=momentum))

    @torch.no_grad()
    def step(self):
        for group in self.param_groups:
            for p in group["params"]:
                mean = self.state[p].setdefault("momentum", torch.zeros_like(p))
                mean.lerp_(p.grad, 1 - group["momentum"])
                ahead = p.grad.lerp(mean, group["momentum"])  # Nesterov
                direction = orthogonal(ahead.flatten(1)).view_as(p)
                p.mul_(1 - group["lr"] * group["weight_decay"])
                p.add_(direction, alpha=-group["lr"] * 0.2 * max(p.shape[0], p[0].numel()) ** 0.5)


def orthogonal(matrix):
    """The nearest matrix with singular values near 1, by five Newton-Schulz steps.

    Each step left-multiplies by a polynomial of the Gram matrix. Kernels are far wider than high, so the polynomials
    are multiplied first, and the kernel itself only once. In float32: rounding to bfloat16 would give a gradient's Gram
    matrix negative eigenvalues, which the steps would amplify.
    """
    if matrix.shape[0] > matrix.shape[1]:
        return orthogonal(matrix.T).T
    x = matrix / (matrix.norm() + 1e-7)
    gram, product = x @ x.T, None
    for step in range(5):
        factor = torch.addmm(gram, gram, gram, beta=-4.7750, alpha=2.0315)
        factor.diagonal().add_(3.4445)
        product = factor if product is None else factor @ product
        if step < 4:
            gram = factor @ gram @ factor
    return product @ x


class Both:
    """Wraps two optimizers as one."""

    def __init__(self, *parts):
        self.parts = parts

    @property
    def param_groups(self):
        return [group for part in self.parts for group in part.param_groups]

    def zero_grad(self):
        for part in self.parts:
            part.zero_grad()

    def step(self):
        for part in self.parts:
            part.step()

    def state_dict(self):
        return [part.state_dict() for part in self.parts]

    def load_state_dict(self, states):
        for part, state in zip(self.parts, states):
            part.load_state_dict(state)


OPTIMIZERS = dict(adamw=adamw, muon=muon)
