!> Writes the C source of libasperity_generic: the symbols that MGIS reads of each behaviour, with names and bounds of
!> the contract, and its functions. The build runs it: write_symbols FILE.
program write_symbols
  use asperity_contract, only: n_facet_statev, n_plane_statev, n_point_statev, n_statev, prop_table, prop_type, &
    statev_row, statev_table, version
  use asperity_generic, only: behaviour_name, material_properties, most_planes, name_length
  use asperity_kinds, only: wp
  use asperity_text, only: integer_text, to_text
  implicit none
  !> Longest text in a list, longest name of a function.
  integer, parameter :: text_length = 32
  !> What a behaviour may assume of the deformation, with the number of components of a joint and of a layer (0: none).
  character(len=text_length), parameter :: hypotheses(5) = [character(len=text_length) :: "Tridimensional", &
    "PlaneStrain", "Axisymmetrical", "GeneralisedPlaneStrain", "PlaneStress"]
  integer, parameter :: of_joint(5) = [3, 2, 2, 2, 2], of_layer(5) = [6, 4, 4, 4, 0]
  !> Type numbers of MGIS.
  integer, parameter :: scalar = 0, symmetric_tensor = 1, vector = 2
  character(len=1024) :: path
  integer :: n, unit

  call get_command_argument(1, path)
  open (newunit=unit, file=trim(path), action="write", status="replace")
  write (unit, "(a)") "/* Written by write_symbols from the contract of asperity " // version // ". */"
  write (unit, "(a)") "int asperity_generic_joint(void *point, int n_planes, int n);"
  write (unit, "(a)") "int asperity_generic_layer(void *point, int n_planes, int n);"
  do n = 1, most_planes
    call write_behaviour(.false., n)
    call write_behaviour(.true., n)
  end do
  close (unit)

contains

  !> All symbols of a behaviour.
  subroutine write_behaviour(layer, n_planes)
    logical, intent(in) :: layer      !! layer or joint
    integer, intent(in) :: n_planes   !! number of planes
    character(len=text_length) :: gradient, force
    character(len=name_length) :: name
    character(len=:), allocatable :: call_of
    integer :: components(size(hypotheses))
    integer :: i, kind_of_gradient

    name = behaviour_name(layer, n_planes)
    gradient = merge("Strain             ", "OpeningDisplacement", layer)
    force = merge("Stress       ", "CohesiveForce", layer)
    kind_of_gradient = merge(symmetric_tensor, vector, layer)
    components = merge(of_layer, of_joint, layer)

    write (unit, "(/, a)") "/* " // trim(name) // " */"
    call number(name, "mfront_mkt", 1)
    call number(name, "api_version", 1)
    call number(name, "BehaviourType", merge(1, 3, layer))
    call number(name, "BehaviourKinematic", merge(1, 2, layer))
    ! isotropic means that the caller rotates strain and stress to the axes of the joint
    call number(name, "SymmetryType", 0)
    call number(name, "ElasticSymmetryType", 0)
    call number(name, "requiresStiffnessTensor", 0)
    call number(name, "requiresThermalExpansionCoefficientTensor", 0)
    call number(name, "TemperatureRemovedFromExternalStateVariables", 0)
    call number(name, "ComputesInternalEnergy", 1)
    call number(name, "ComputesDissipatedEnergy", 1)
    call number(name, "UsableInPurelyImplicitResolution", 1)
    call number(name, "nInitializeFunctions", 0)
    call number(name, "nPostProcessings", 0)
    call text(name, "mfront_interface", "Generic")
    call text(name, "tfel_version", "none")
    call text(name, "build_id", "asperity " // version)
    call text(name, "src", "asperity")
    call text(name, "unit_system", "")
    call text(name, "author", "")
    call text(name, "date", "")
    call text(name, "validator", "")
    call texts(name, "ModellingHypotheses", pack(hypotheses, components > 0))
    call texts(name, "Gradients", [gradient])
    call integers(name, "GradientsTypes", [kind_of_gradient])
    call texts(name, "ThermodynamicForces", [force])
    call integers(name, "ThermodynamicForcesTypes", [kind_of_gradient])
    ! one block: derivative of the first with respect to the second
    call texts(name, "TangentOperatorBlocks", [force, gradient])
    call texts(name, "InternalStateVariables", variable_names(n_planes))
    call integers(name, "InternalStateVariablesTypes", spread(scalar, 1, n_statev(n_planes, .true.)))
    call nothing(name, "ExternalStateVariables")
    call nothing(name, "Parameters")
    call write_properties(name, pack(prop_table, material_properties(layer)))
    call_of = merge("asperity_generic_layer", "asperity_generic_joint", layer)
    do i = 1, size(hypotheses)
      if (components(i) == 0) cycle
      write (unit, "(a)") "int " // trim(name) // "_" // trim(hypotheses(i)) // "(void *point) { return " // &
        call_of // "(point, " // integer_text(n_planes) // ", " // integer_text(components(i)) // "); }"
    end do
  end subroutine write_behaviour

  !> Names of the material properties, and their bounds.
  subroutine write_properties(name, rows)
    character(len=*), intent(in) :: name      !! behaviour
    type(prop_type), intent(in) :: rows(:)    !! entries of PROPS
    character(len=text_length) :: names(size(rows))
    integer :: i
    names = rows%name
    call texts(name, "MaterialProperties", names)
    do i = 1, size(rows)
      if (rows(i)%lower > -huge(1.0_wp)) call bound(name, trim(rows(i)%name) // "_LowerPhysicalBound", rows(i)%lower)
      if (rows(i)%upper < huge(1.0_wp)) call bound(name, trim(rows(i)%name) // "_UpperPhysicalBound", rows(i)%upper)
    end do
  end subroutine write_properties

  !> Names of the state variables, those of the facets included; those of a plane end with its number.
  pure function variable_names(n_planes) result(names)
    integer, intent(in) :: n_planes   !! number of planes
    character(len=text_length) :: names(n_statev(n_planes, .true.))
    integer :: i, plane
    do i = 1, size(names)
      names(i) = statev_table(statev_row(i, n_planes))%name
      plane = (i - n_point_statev - 1)/n_plane_statev + 1
      if (i > n_statev(n_planes)) plane = (i - n_statev(n_planes) - 1)/n_facet_statev + 1
      if (i > n_point_statev) names(i) = trim(names(i)) // "_" // integer_text(plane)
    end do
  end function variable_names

  !> A count or a switch.
  subroutine number(name, what, value)
    character(len=*), intent(in) :: name, what   !! behaviour, symbol
    integer, intent(in) :: value                 !! its value
    write (unit, "(a)") "const unsigned short " // trim(name) // "_" // what // " = " // integer_text(value) // ";"
  end subroutine number

  !> A bound in full precision.
  subroutine bound(name, what, value)
    character(len=*), intent(in) :: name, what   !! behaviour, symbol
    real(wp), intent(in) :: value                !! its value
    write (unit, "(a)") "const long double " // trim(name) // "_" // what // " = " // to_text(value) // ";"
  end subroutine bound

  !> A text.
  subroutine text(name, what, value)
    character(len=*), intent(in) :: name, what   !! behaviour, symbol
    character(len=*), intent(in) :: value        !! its value
    write (unit, "(a)") "const char *const " // trim(name) // "_" // what // ' = "' // value // '";'
  end subroutine text

  !> A list of texts and its length.
  subroutine texts(name, what, values)
    character(len=*), intent(in) :: name, what               !! behaviour, symbol
    character(len=text_length), intent(in) :: values(:)      !! its values
    integer :: i
    call number(name, "n" // what, size(values))
    write (unit, "(a)") "const char *const " // trim(name) // "_" // what // "[] = {"
    write (unit, "(2x, a)") ('"' // trim(values(i)) // '",', i=1, size(values))
    write (unit, "(a)") "};"
  end subroutine texts

  !> A list of integers.
  subroutine integers(name, what, values)
    character(len=*), intent(in) :: name, what   !! behaviour, symbol
    integer, intent(in) :: values(:)             !! its values
    integer :: i
    write (unit, "(*(a))") "const int ", trim(name), "_", what, "[] = {", &
      (integer_text(values(i)) // ", ", i=1, size(values)), "};"
  end subroutine integers

  !> An empty list of variables with their types.
  subroutine nothing(name, what)
    character(len=*), intent(in) :: name, what   !! behaviour, symbol
    call number(name, "n" // what, 0)
    write (unit, "(a)") "const char *const *const " // trim(name) // "_" // what // " = 0;"
    write (unit, "(a)") "const int *const " // trim(name) // "_" // what // "Types = 0;"
  end subroutine nothing

end program write_symbols
