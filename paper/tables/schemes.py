"""The schemes of the study: title, family, order, kind and source."""

import pandas as pd
import xarray as xr

from paper.tables.writing import main


def tabulate(energy_error: xr.Dataset) -> pd.DataFrame:
    """One row a scheme."""
    scheme = energy_error.scheme
    return pd.DataFrame(
        {
            "Scheme": scheme.scheme_title,
            "Name": scheme,
            "Family": scheme.family,
            "Order": scheme.order,
            "Kind": ["explicit" if explicit else "implicit" for explicit in scheme.explicit],
            "Source": scheme.scheme_source,
        }
    )


if __name__ == "__main__":
    main(tabulate)
