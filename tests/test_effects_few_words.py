"""Keys of effects in few words."""

from sym2real.effects.few_words import in_few_words


def test_columns_of_a_kind_stand_together_and_the_kind_by_itself() -> None:
    assert in_few_words(["lag:wx_cmd", "delay", "lag:wy_cmd", "delay:steer"]) == [
        *("lag:{wx_cmd,wy_cmd}", "delay", "delay:steer")
    ]
    assert in_few_words([f"sensor_bias:{name}" for name in "vwxyz"]) == ["sensor_bias:*"]
    assert in_few_words([]) == []
