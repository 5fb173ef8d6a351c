!> Everything that there is to know of a state, found for all methods alike.
submodule(taut_constrained_method) taut_constrained_method_sampling
   use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
   use taut_constrained_system_tables, only: tabulated_system_t
   implicit none (type, external)

contains

   !> Violations, multipliers, energy, rank and what the system computes besides at a state, evaluated afresh.
   module procedure sample
      integer :: iterations

      if (.not. allocated(s%mu)) allocate (s%mu(self%model%c), s%lambda(self%model%c), source=0.0_wp)
      associate (model => self%model, projector => self%projector)
         ! Output does not count as work of the method.
         iterations = projector%newton%iterations
         call self%rhs(t, y, self%dydt, info)
         projector%newton%iterations = iterations
         if (info /= rhs_ok) return
         call self%accelerations(self%dydt, self%vdot)
         call self%multipliers(s%lambda)
         s%weakest = self%mass%weakest(projector)
         if (self%finds_mu .and. .not. self%replaces) call self%velocity_multipliers(s%mu)

         call self%unpack(t, y, self%at)
         self%evaluated = .false.
         call projector%linear%linearize(model, self%at, info, 0.0_wp)
         if (info /= rhs_ok) return
         s%rank = projector%linear%onto%rank
         call self%find_violations()
         s%phi = largest(self%phi)
         s%phidot = largest(self%phidot)
         call model%acceleration_rhs(self%at, self%b_second)
         call projector%linear%a%multiply(self%vdot, self%phidot, self%b_second)
         s%phiddot = largest(self%phidot)
         s%energy = model%energy(self%at)
         call model%mass(self%at, self%m)
         call self%m%multiply(self%at%v, self%vdot)
         s%kinetic = 0.5_wp*dot_product(self%at%v, self%vdot)
         self%kinetic_of_unit = 0.5_wp*self%m%trace()
         s%work = self%integral + self%blows%energy
         if (.not. self%has_integral) s%work = ieee_value(s%work, ieee_quiet_nan)
         call find_outputs(self, s)
         if (self%replaces) then
            s%phi_raw = self%step_end%phi
            s%phidot_raw = self%step_end%phidot
            s%mu(:) = self%step_end%mu
            call projector%linear%onto%minimum_norm(s%mu)
         else
            s%phi_raw = s%phi
            s%phidot_raw = s%phidot
            if (self%finds_mu) return
            call projector%velocity(model, self%at)
            call self%velocity_multipliers(s%mu)
         end if
      end associate
   end procedure sample

   !> The multipliers lambda at a state, at no further cost where the last evaluation was, and what the system computes besides.
   module procedure sample_reactions
      integer :: iterations
      logical :: known

      if (.not. allocated(s%mu)) allocate (s%mu(self%model%c), s%lambda(self%model%c), source=0.0_wp)
      info = rhs_ok
      known = self%evaluated
      if (known) known = self%is_at(t, y)
      if (.not. known) then
         iterations = self%projector%newton%iterations
         call self%rhs(t, y, self%dydt, info)
         self%projector%newton%iterations = iterations
         if (info /= rhs_ok) return
         call self%unpack(t, y, self%at)
      end if
      call self%multipliers(s%lambda)
      s%weakest = self%mass%weakest(self%projector)
      if (outputs) call find_outputs(self, s)
   end procedure sample_reactions

   !> What the system computes besides at `at`.
   subroutine find_outputs(self, s)
      class(constrained_ode_t), intent(in) :: self
      type(sample_t), intent(inout) :: s

      select type (model => self%model)
      class is (tabulated_system_t)
         if (.not. allocated(s%outputs)) allocate (s%outputs(model%n_outputs), source=0.0_wp)
         if (model%n_outputs > 0) call model%outputs(self%at, s%lambda, s%outputs)
      end select
   end subroutine find_outputs

   !> Largest absolute entry, 0 if there is none.
   pure function largest(values) result(value)
      real(wp), intent(in) :: values(:)
      real(wp) :: value
      integer :: i

      value = 0.0_wp
      do i = 1, size(values)
         value = max(value, abs(values(i)))
      end do
   end function largest

end submodule taut_constrained_method_sampling
