"""Transfer between particles and grid over the nodes of a support, in one, two and three dimensions.

A support is a record with four methods. Values of nodes (C, n) are counted with x fastest; C are the components of what is
transferred, and `component` is the first row that it is added to.

spread(grid, nodes, component, a)
    Particles to grid: a_I += N_Ip a.
spread_tensor(grid, nodes, component, T)
    Particles to grid: a_I += sum_k T_k dN_Ip/dx_k, T_k the columns of a tensor.
gather(grid, nodes)
    Grid to particles: the vector sum_I N_Ip a_I.
gather_tensor(grid, nodes)
    Grid to particles: the tensor with rows c and columns k, sum_I a_Ic dN_Ip/dx_k, row-major.
"""

from typing import Any, NamedTuple

from ..tracing import load_row, traced
from .nodes import add_field, gathered, gathered_by
from .state import Grid
from .vectors import by_components, dot, less

# Tuples whose length is known only while a function is traced have no annotation.
# mypy: disable-error-code="no-untyped-def"


class Products(NamedTuple):
    """Support where N_Ip is a product of functions along the axes.

    first : int
        Number of the first node.
    N : tuple
        Functions (d, W) [1].
    derivative : tuple
        Their derivatives (d, W) [1/m].
    begin : tuple of int
        First node along the axes (d,).
    offset : tuple
        Distances of the particles from the lower ends in cells, less the numbers of the first nodes (d,).
    """

    first: Any
    N: Any
    derivative: Any
    begin: Any
    offset: Any

    def spread(self, grid: Grid, nodes, component, amount):
        add_field(grid, nodes, component, self.first, self.N, self.N, amount, None)

    def spread_tensor(self, grid: Grid, nodes, component, T):
        add_field(grid, nodes, component, self.first, self.N, self.derivative, None, T)

    def gather(self, grid: Grid, nodes):
        return gathered(grid, nodes, self.first, self.N)

    def gather_tensor(self, grid: Grid, nodes):
        return gathered_by(grid, nodes, self.first, self.N, self.derivative)

    def moments(self, grid: Grid):
        """N (x_I - x) along the axes (d, W), and the diagonal of D = sum_I N (x_I - x)(x_I - x)^T (d,), in cells."""
        axes = range(len(self.offset))
        return zip(*(moment_along(grid, k, self.begin[k], self.offset[k], self.N[k]) for k in axes), strict=True)


@traced
def moment_along(grid: Grid, k: int, first: int, offset, N):
    """N (x_I - x) (W,) and D = sum_I N (x_I - x)^2 along axis k, in cells, at an offset from the first node's number in cells."""
    from_here = less(less(load_row(grid.nodes, (k, first), N), 1.0 * first), offset)
    moment = by_components(N, from_here)
    return moment, dot(moment, from_here)
